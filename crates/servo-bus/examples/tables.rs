//! Prints all control tables of Dynamixels as tab-separated values: model number, firmware, address, size, access,
//! name.

use sinew_servo_bus::dynamixel::table::{MODELS, Table};
use sinew_servo_bus::table::Access;

fn main() {
    for model in MODELS {
        // Firmware 52 moved the indirect data of small servos: the last version before it, and the first after.
        for firmware in [51, 52] {
            let table = Table { model, firmware };
            let indirect = table.indirect().into_iter().flatten();
            let indirect = indirect.flat_map(|run| [run.addresses, run.data]);
            let indirect = indirect.filter_map(|address| table.at(address));
            for item in table.items().chain(indirect) {
                let access = if item.access == Access::ReadWrite { "RW" } else { "R" };
                let (address, size, name) = (item.address, item.size, item.name);
                println!("{}\t{firmware}\t{address}\t{size}\t{access}\t{name}", model.number);
            }
        }
    }
}
