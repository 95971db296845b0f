//! Tests of both protocols and the PCA9685, from both ends of the wire.

mod compare;
mod cycle;
mod damage;
mod devices;
mod dynamixel_tables;
mod kinds;
mod manual_bytes;
mod pca9685;
mod profile;
mod reference;
mod streams;
