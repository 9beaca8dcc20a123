//! What the dialects of the firmwares do differently.

use crate::settings::GcodeFlavor;

/// Sets the fan to a step of 0..=255.
pub fn fan(flavor: GcodeFlavor, step: u8) -> String {
    // RepRapFirmware calls M107 outdated.
    if step == 0 && flavor != GcodeFlavor::Reprapfirmware {
        "M107\n".to_owned()
    } else {
        format!("M106 S{step}\n")
    }
}

/// The firmware's step, 0..=255, nearest to a fan speed of 0..=100 \[%\].
pub fn fan_step(percent: f64) -> u8 {
    (percent * 255.0 / 100.0).clamp(0.0, 255.0).round() as u8
}

/// Sets the temperature of the nozzle \[°C\], and waits for it or not.
pub fn nozzle_temperature(celsius: u32, wait: bool) -> String {
    if wait {
        format!("M109 S{celsius} ; set temperature and wait for it to be reached\n")
    } else {
        format!("M104 S{celsius} ; set temperature\n")
    }
}

/// Sets the temperature of the bed \[°C\], and waits for it or not.
pub fn bed_temperature(celsius: u32, wait: bool) -> String {
    if wait {
        format!("M190 S{celsius} ; set bed temperature and wait for it to be reached\n")
    } else {
        format!("M140 S{celsius} ; set bed temperature\n")
    }
}

/// Tells the host how many layers there are; only Klipper listens.
pub fn layer_count(flavor: GcodeFlavor, count: usize) -> Option<String> {
    (flavor == GcodeFlavor::Klipper).then(|| format!("SET_PRINT_STATS_INFO TOTAL_LAYER={count}\n"))
}

/// Tells the host which layer begins, counted from 1; only Klipper listens.
pub fn current_layer(flavor: GcodeFlavor, number: usize) -> Option<String> {
    (flavor == GcodeFlavor::Klipper).then(|| format!("SET_PRINT_STATS_INFO CURRENT_LAYER={number}\n"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fan_goes_from_off_to_255() {
        assert_eq!(fan(GcodeFlavor::Marlin2, 0), "M107\n");
        assert_eq!(fan(GcodeFlavor::Reprapfirmware, 0), "M106 S0\n");
        assert_eq!(fan(GcodeFlavor::Klipper, fan_step(100.0)), "M106 S255\n");
        assert_eq!(fan(GcodeFlavor::Marlin, fan_step(50.0)), "M106 S128\n");
    }
}
