use crate::zipped::*;
use microtome::resin::nanodlp::NanoDlp;
use serde_json::Value;

#[test]
fn comes_back() {
    round_trip(&NanoDlp);
}

#[test]
fn damage_is_noticed() {
    damage(&NanoDlp);
}

#[test]
fn has_the_members_and_fields_of_the_format() {
    let print = print(5);
    let bytes = write(&NanoDlp, &print, &masks(&print.panel, 5, 1));
    let members = members(&bytes);
    let json = |name: &str| -> Value {
        let (_, text) = members.iter().find(|(n, _)| n == name).expect(name);
        serde_json::from_slice(text).unwrap()
    };
    assert_eq!(json("meta.json")["FormatVersion"], 2);
    assert_eq!(json("options.json"), json("slicer.json"));
    assert_eq!(json("options.json")["PWidth"], 61);
    assert_eq!(json("options.json")["Thickness"], 50.0);
    assert_eq!(json("options.json")["YPixelSize"], 0.024);
    assert_eq!(json("profile.json")["SupportCureTime"], 30.0);
    assert_eq!(json("plate.json")["LayersCount"], 5);
    assert_eq!(json("plate.json")["TotalSolidArea"], 6.75);
    let info = json("info.json");
    assert_eq!(info.as_array().unwrap().len(), 5);
    assert_eq!(
        (&info[0]["AreaCount"], &info[1]["MaxX"], &info[2]["MinY"]),
        (&0.into(), &60.into(), &42.into())
    );
    for name in ["1.png", "5.png", "3d.png"] {
        assert!(members.iter().any(|(n, _)| n == name), "{name}");
    }
    let reader = open(bytes).unwrap();
    let head = reader.head();
    assert_eq!((head.layer_height, head.exposure, head.bottom_layers), (0.05, 2.5, 3));
}

#[test]
fn contradictions_are_named() {
    let print = print(5);
    let bytes = write(&NanoDlp, &print, &masks(&print.panel, 5, 1));
    for (member, change, says) in [
        ("3.png", None, "picture 3.png"),
        ("slicer.json", Some(("61", "62")), "61 x 43, expected 62 x 43"),
        ("slicer.json", Some(("\"PWidth\":61", "\"PWidth\":1e308")), "PWidth"),
        ("meta.json", Some(("2", "7")), "FormatVersion"),
        ("meta.json", Some(("{", "[")), "JSON"),
        ("plate.json", Some(("\"LayersCount\":5", "\"LayersCount\":4000000000")), "LayersCount"),
        ("plate.json", Some(("\"LayersCount\":5", "\"LayersCount\":\"5\"")), "LayersCount"),
    ] {
        let error = error_after(&bytes, member, change);
        assert!(error.contains(says), "{error}");
    }
}
