//! How far light goes in a time, there and back.

/// Speed of light in vacuum (exact, SI).
pub const SPEED_OF_LIGHT_M_PER_S: f64 = 299_792_458.0;

/// Distance of a target whose light is under way for `delay_ps`, there and back: half
/// the path (eq. 1).
pub fn distance_m(delay_ps: f64) -> f64 {
    0.5 * delay_ps * 1e-12 * SPEED_OF_LIGHT_M_PER_S
}

/// Time that light takes to a target at `distance_m` and back.
pub fn round_trip_ps(distance_m: f64) -> f64 {
    2.0 * distance_m / SPEED_OF_LIGHT_M_PER_S * 1e12
}
