//! Compares our control tables with the makers' machine-readable tables: see `facts/dynamixel_tables.tsv`.

use sinew_servo_bus::dynamixel::table::{MODELS, Table, address};
use sinew_servo_bus::table::{Access, ByteOrder};

const FACTS: &str = include_str!("facts/dynamixel_tables.tsv");

fn facts() -> impl Iterator<Item = (u16, u8, u16, u8, &'static str)> {
    FACTS.lines().filter(|line| !line.starts_with('#')).map(|line| {
        let mut fields = line.split('\t');
        let mut number = || fields.next().unwrap().parse::<u16>().unwrap();
        let (model, firmware, address, size) = (number(), number(), number(), number());
        let small = |number: u16| u8::try_from(number).unwrap();
        (model, small(firmware), address, small(size), fields.next().unwrap())
    })
}

#[test]
fn addresses_sizes_and_names_are_the_makers() {
    let mut compared = 0;
    for (model, firmware, address, size, name) in facts() {
        let table = Table::of(model, firmware).unwrap();
        let item = table
            .at(address)
            .unwrap_or_else(|| panic!("model {model} has no item at {address}: {name}"));
        assert_eq!((item.address, item.size), (address, size), "model {model}: {name}");
        let ours = item.name.to_lowercase();
        // The maker's list names the first indirect item, and writes "BUS Watchdog" for MX.
        let theirs = name.to_lowercase();
        let theirs =
            if theirs.starts_with("indirect") { theirs.trim_end_matches(" 1") } else { &theirs };
        assert_eq!(ours, theirs, "model {model} at {address}");
        compared += 1;
    }
    assert!(compared > 800, "only {compared} items compared");
}

/// Registers that are in the manual, but not in the makers' files.
const ONLY_IN_THE_MANUAL: [&str; 2] = ["Startup Configuration", "Backup Ready"];

#[test]
fn no_item_is_ours_alone() {
    for model in MODELS {
        let table = Table { model, firmware: 52 };
        for item in table.items() {
            let known = facts()
                .any(|(number, _, address, ..)| number == model.number && address == item.address);
            assert!(
                known || ONLY_IN_THE_MANUAL.contains(&item.name),
                "{}: {}",
                model.name,
                item.name
            );
        }
    }
}

#[test]
fn items_do_not_overlap_and_begin_within_range() {
    for model in MODELS {
        for firmware in [40, 52] {
            let table = Table { model, firmware };
            let items: Vec<_> = table.items().collect();
            assert!(
                items.windows(2).all(|pair| pair[0].end() <= pair[1].address),
                "{}",
                model.name
            );
            for address in 0..1_024 {
                if let Some(item) = items.iter().find(|item| item.contains(address)) {
                    assert_eq!(table.at(address), Some(*item), "{}: {address}", model.name);
                }
            }
            for item in items {
                let bytes = item.bytes(item.initial, ByteOrder::Little);
                assert_eq!(
                    item.value(&bytes, ByteOrder::Little),
                    item.initial,
                    "{}: {}",
                    model.name,
                    item.name
                );
                assert_eq!(table.named(&item.name.to_uppercase().replace(' ', "_")), Some(item));
            }
        }
    }
}

/// Source: the `.model` files of `dynamixel-sdk`, as in `facts/dynamixel_tables.tsv`.
#[test]
fn indirect_data_of_small_servos_moved_with_firmware_52() {
    let data = |model, firmware| Table::of(model, firmware).unwrap().indirect()[0].unwrap().data;
    assert_eq!((data(1200, 51), data(1200, 52)), (224, 208));
    assert_eq!((data(1060, 45), data(1060, 52)), (224, 224));
    let table = Table::of(1200, 52).unwrap();
    assert_eq!(
        (table.size(), table.at(227).unwrap().name, table.at(228)),
        (228, "Indirect Data", None)
    );
    assert_eq!(table.at(206).unwrap().initial, 227);
    assert_eq!(Table::of(1020, 45).unwrap().at(632).unwrap().initial, 661);
}

#[test]
fn what_is_measured_is_not_written() {
    for model in MODELS {
        let table = Table { model, firmware: 52 };
        assert!(
            table
                .items()
                .filter(|item| item.name.starts_with("Present"))
                .all(|item| item.access == Access::Read)
        );
        assert_eq!(
            table.at(address::CURRENT_LIMIT).is_some(),
            model.current.is_some(),
            "{}",
            model.name
        );
    }
}

#[test]
fn an_address_is_that_of_the_one_item_that_has_it() {
    for model in MODELS {
        for firmware in [45, 52] {
            let table = Table { model, firmware };
            for address in 0..1024 {
                let by_search = table.items().find(|item| item.contains(address));
                let found = table.at(address);
                assert!(by_search.is_none() || by_search == found, "{}: {address}", model.name);
                assert!(found.is_none_or(|item| item.contains(address)));
            }
        }
    }
}
