//! x

pub mod element;
pub mod error;
pub mod integrate;
pub mod interface;
pub mod material;
pub mod mesh;
pub mod pack;
pub mod rates;
pub mod scheme;
pub mod spectrum;
pub mod statics;
pub mod wheel;
