//! The list of resin printers.

use super::{Bench, stderr, stdout};

#[test]
fn the_list_and_its_json_name_the_same_printers() {
    let bench = Bench::new();
    let list = bench.run(["printers"]);
    assert!(list.status.success(), "{}", stderr(&list));
    let json = bench.run(["printers", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&stdout(&json)).unwrap();
    let json = json.as_array().unwrap();
    assert!(json.len() >= 8);
    for printer in json {
        let slug = printer["slug"].as_str().unwrap();
        assert!(stdout(&list).lines().any(|l| l.starts_with(&format!("{slug} "))), "{slug}");
    }
}

#[test]
fn one_printer_is_a_settings_file() {
    let bench = Bench::new();
    let text = stdout(&bench.run(["printers", "elegoo-saturn-3-ultra"]));
    let mut settings = microtome::settings::Settings::resin();
    let path = bench.write("mine.toml", text.replace("max_print_height = 260", "max_print_height = 99"));
    microtome::settings::load_file(&path, &mut settings).unwrap();
    assert_eq!((settings.display.display_pixels_x, settings.printer.max_print_height), (11_520, 99.0));
    let json = bench.run(["printers", "prusa-sl1s", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&stdout(&json)).unwrap();
    assert_eq!((&json["container"], &json["settings"]["printer_model"]), (&"sl1s".into(), &"SL1S".into()));
}

#[test]
fn an_unknown_printer_and_the_wrong_technology_are_refused() {
    let bench = Bench::new();
    let done = bench.run(["printers", "elegoo-satrun-3"]);
    assert_eq!(done.status.code(), Some(4));
    assert!(stderr(&done).contains("did you mean elegoo-saturn-3?"), "{}", stderr(&done));
    bench.write("resin.ini", "printer_technology = SLA\n");
    let done = bench.run(["slice", "box.stl", "--load", "resin.ini"]);
    assert_eq!(done.status.code(), Some(4));
    assert!(stderr(&done).contains("resin.ini:1: printer_technology = \"SLA\" means a resin printer"));
}
