//! The board: rigless's STM32F427 with the differences of the F446RE, and a host at the far end of two serial ports.

use std::num::{NonZeroU32, NonZeroU64};

use rigless::cpu::armv7m::windows;
use rigless::emulator::Alias;
use rigless::machine::armv7m::{Core, Fpu, MpuRegions, Variant};
use rigless::machine::{Board, Crystal, Target};
use rigless::mcu::{Mcu, Operate as _};
use rigless::snapshot::Store;
use rigless::soc::stm32f427::Stm32f427;
use rigless::soc::stm32f427::generated::usart6::{Register, cr1};
use rigless::soc::{Error, Region};

use crate::flash::{ARRAY, BASE, LEN};
use crate::wire::Wire;

/// Clock of the ST-Link on the oscillator's pin, Hz.
const HSE: Crystal = Crystal(8_000_000);
const SUPPLY_MV: u32 = 3300;
const CORE_HZ: NonZeroU64 = NonZeroU64::new(180_000_000).unwrap();
/// Instructions per second: 8 ns each, 1.44 cycles at 180 MHz. This is a guess for a Cortex-M4 that runs from flash
/// through the ART cache. Cycles are not counted.
const INSTRUCTIONS_PER_S: NonZeroU64 = NonZeroU64::new(125_000_000).unwrap();

/// A serial port with a host: its index in rigless's list.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Port {
    /// USART1: the bus line of the servos, half duplex.
    Bus = 0,
    /// USART2: the virtual port of the ST-Link.
    Link = 1,
}

impl Port {
    /// Returns the name of the port in lines of text.
    pub fn name(self) -> &'static str {
        match self {
            Self::Bus => "bus",
            Self::Link => "link",
        }
    }
}

/// The NUCLEO-F446RE. The F427 has all parts of the F446 that our image uses, at the same addresses. It has more
/// flash and RAM, which the image does not use.
#[derive(Debug)]
pub struct Nucleo {
    pub mcu: Stm32f427,
    /// Whether the array is mapped at the address of flash. A new session refuses two regions at one address, so
    /// this is set after the session is created. Each run reads the regions again, and the core uses the last
    /// region at an address.
    pub is_array_in_place: bool,
}

impl Nucleo {
    pub fn new() -> Result<Self, Error> {
        let mut mcu = Stm32f427::new()?;
        // Flash that the image can program: rigless's model of this part is read-only.
        mcu.bus_mut().add_region(Region::ram("array", ARRAY, LEN as u64).erased_to(0xFF))?;
        mcu.rcc.attach_crystals(HSE.0, Crystal::NONE.0);
        mcu.set_supply(SUPPLY_MV);
        for port in [Port::Bus, Port::Link] {
            mcu.usart[port as usize].attach(Wire::default());
        }
        Ok(Self { mcu, is_array_in_place: false })
    }

    /// Returns the rate of USART1, bit/s.
    pub fn bus_baud(&mut self) -> u64 {
        let (_, registers) = self.mcu.serial_port(Port::Bus as usize);
        // `USARTDIV` in sixteenths, or in eighths.
        let (divider, is_by_8) = (registers.get(Register::Brr), registers.get(Register::Cr1));
        let divider = match cr1::OVER8.is_set(is_by_8) {
            true => divider >> 4 << 3 | divider & 7,
            false => divider,
        };
        let (clocks, registers) = self.mcu.clocks();
        clocks.pclk2(registers) / divider.max(1)
    }

    /// Returns the far end of a port.
    pub fn wire(&mut self, port: Port) -> &mut Wire {
        self.mcu.usart[port as usize].chip_mut().expect("`new` attaches it")
    }
}

/// Nothing is saved: a run begins at power-on.
impl Store for Nucleo {}

impl Board for Nucleo {
    fn name(&self) -> &'static str {
        "nucleo-f446re"
    }

    fn target_names(&self) -> Vec<&'static str> {
        vec!["mcu"]
    }

    fn mcu(&mut self, target: usize) -> Option<&mut dyn Mcu> {
        (target == 0).then_some(&mut self.mcu)
    }

    fn targets(&mut self) -> Vec<Target<'_>> {
        let lines = NonZeroU32::new(u32::from(self.mcu.cpu().interrupt_lines));
        let core = Core {
            variant: Variant::M4,
            clock_hz: CORE_HZ,
            interrupt_lines: lines.expect("the part has interrupts"),
            priority_bits: 4,
            refclk_divider: NonZeroU32::new(8).unwrap(),
            instructions_per_second: INSTRUCTIONS_PER_S,
            boot: "flash",
        };
        let mut spec =
            core.spec_with_parts(&windows(self.mcu.bus()), Fpu::FpV4Sp, MpuRegions::Eight);
        if self.is_array_in_place {
            spec.aliases.push(Alias { region: "array", at: BASE });
        }
        vec![Target::new("mcu", &mut self.mcu, spec)]
    }
}
