//! Both protocols and the PCA9685, from both ends of the wire.

mod compare;
mod corpus;
mod cycle;
mod damage;
mod decoders;
mod devices;
mod dynamixel_tables;
mod manual_bytes;
mod pca9685;
mod profile;
mod reference;
mod replay;
mod streams;
