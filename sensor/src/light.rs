//! How far light goes in a time, there and back, and how many photons it is.

/// Speed of light in vacuum (exact, SI).
pub const SPEED_OF_LIGHT_M_PER_S: f64 = 299_792_458.0;

/// Planck constant (exact, SI).
const PLANCK_J_S: f64 = 6.626_070_15e-34;

/// Photons per second in `power_w` of light: P lambda / (h c), the first factor of
/// eq. 5.
pub fn photon_rate_hz(power_w: f64, wavelength_nm: f64) -> f64 {
    power_w * wavelength_nm * 1e-9 / (PLANCK_J_S * SPEED_OF_LIGHT_M_PER_S)
}

/// Distance of a target whose light is under way for `delay_ps`, there and back: half
/// the path (eq. 1).
pub fn distance_m(delay_ps: f64) -> f64 {
    0.5 * delay_ps * 1e-12 * SPEED_OF_LIGHT_M_PER_S
}

/// Time that light takes to a target at `distance_m` and back.
pub fn round_trip_ps(distance_m: f64) -> f64 {
    2.0 * distance_m / SPEED_OF_LIGHT_M_PER_S * 1e12
}
