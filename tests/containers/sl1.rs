use crate::zipped::*;
use microtome::resin::sl1::Sl1;

#[test]
fn comes_back() {
    round_trip(&Sl1);
}

#[test]
fn damage_is_noticed() {
    damage(&Sl1);
}

#[test]
fn has_the_members_that_printers_and_slicers_need() {
    let print = print(5);
    let bytes = write(&Sl1, &print, &masks(&print.panel, 5, 1));
    let members = members(&bytes);
    let names: Vec<_> = members.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(
        names,
        [
            "prusaslicer.ini",
            "thumbnail/thumbnail400x400.png",
            "thumbnail/thumbnail800x480.png",
            "part_700000.png",
            "part_700001.png",
            "part_700002.png",
            "part_700003.png",
            "part_700004.png",
            "config.ini",
        ]
    );
    let config = String::from_utf8(members[8].1.clone()).unwrap();
    let mut lines: Vec<_> = config.lines().collect();
    assert!(lines.is_sorted());
    for line in [
        "action = print",
        "expTime = 2.5",
        "expTimeFirst = 30",
        "fileCreationTimestamp = 2023-11-14 at 22:13:21 UTC",
        "jobDir = part_7",
        "layerHeight = 0.05",
        "numFade = 2",
        "numFast = 3",
        "numSlow = 2",
        "printTime = 1234.5",
        "printerModel = SL1S",
        "usedMaterial = 6.75",
    ] {
        assert!(lines.contains(&line), "{line} is missing in\n{config}");
    }
    let settings = String::from_utf8(members[0].1.clone()).unwrap();
    lines = settings.lines().collect();
    assert!(lines.is_sorted());
    for line in
        ["area_fill = 35", "display_mirror_x = 1", "display_orientation = landscape", "faded_layers = 2"]
    {
        assert!(lines.contains(&line), "{line} is missing in\n{settings}");
    }
}

#[test]
fn portrait_panels_are_described_as_prusaslicer_does() {
    let mut print = print(5);
    print.panel.portrait = true;
    print.panel.mirror_x = false;
    let bytes = write(&Sl1, &print, &masks(&print.panel, 5, 1));
    let settings = String::from_utf8(members(&bytes)[0].1.clone()).unwrap();
    for line in [
        "display_height = 1.159",
        "display_mirror_x = 1",
        "display_orientation = portrait",
        "display_pixels_x = 43",
        "display_pixels_y = 61",
        "display_width = 1.032",
    ] {
        assert!(settings.lines().any(|l| l == line), "{line} is missing in\n{settings}");
    }
    let reader = open(bytes).unwrap();
    let head = reader.head();
    assert_eq!((head.width, head.height, head.mirror), (61, 43, Some([false, false])));
    assert_eq!(head.display, Some([1.159, 1.032]));
}

#[test]
fn says_what_the_firmware_makes_of_it() {
    let print = print(9);
    let mut reader = open(write(&Sl1, &print, &masks(&print.panel, 9, 1))).unwrap();
    let exposures: Vec<f64> = (0..9).map(|i| reader.layer(i).unwrap().1.exposure).collect();
    let step = 27.5 / 3.0;
    let expected = [30.0, 30.0, 30.0, 30.0 - step, 30.0 - 2.0 * step, 2.5, 2.5, 2.5, 2.5];
    assert_eq!(exposures, expected);
    let info = reader.layer(2).unwrap().1;
    assert_eq!((info.z, info.height), (0.2, 0.05));
    assert_eq!((reader.head().time, reader.head().volume_ml), (Some(1234.5), Some(6.75)));
}

#[test]
fn contradictions_are_named() {
    let print = print(5);
    let bytes = write(&Sl1, &print, &masks(&print.panel, 5, 1));
    for (member, change, says) in [
        ("part_700003.png", None, "part_700003.png"),
        ("part_700004.png", None, "5 layers, as numFast and numSlow say"),
        ("config.ini", Some(("numFast = 3", "numFast = 300000000")), "numFast"),
        ("config.ini", Some(("numFade = 2", "numFade = -1")), "numFade"),
        ("config.ini", Some(("expTime = 2.5", "expTime = NaN")), "expTime"),
        ("config.ini", Some(("jobDir = part_7", "jobDir = other")), "at least one layer"),
        ("config.ini", Some(("jobDir", "jobdir")), "jobDir"),
        ("prusaslicer.ini", Some(("pixels_x = 61", "pixels_x = 4000000000")), "the panel"),
        ("prusaslicer.ini", Some(("pixels_x = 61", "pixels_x = 60")), "61 x 43, expected 60 x 43"),
    ] {
        let error = error_after(&bytes, member, change);
        assert!(error.contains(says), "{error}");
    }
}
