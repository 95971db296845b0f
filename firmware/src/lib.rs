//! The hardware-free part of the firmware.
#![no_std]
