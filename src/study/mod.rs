//! Studies made of many simulations: the fidelity of the tiers, the article's
//! figures and claims, stiff and extreme cases, sweeps over a scene's keys.

mod article;
pub mod fidelity;
#[cfg(feature = "plots")]
pub mod reproduce;
pub mod stress;
pub mod sweep;
