use crate::zipped::*;
use microtome::resin::layer_files::open_folder;
use microtome::resin::svg::SvgLayers;

#[test]
fn comes_back() {
    round_trip(&SvgLayers);
}

#[test]
fn damage_is_noticed() {
    damage(&SvgLayers);
}

#[test]
fn folders_come_back() {
    let print = print(6);
    let masks = masks(&print.panel, 6, 5);
    let folder = tempfile::tempdir().unwrap();
    fill(&SvgLayers, SvgLayers.begin_folder(folder.path(), &print).unwrap(), &print, &masks);
    let mut reader = open_folder(folder.path()).unwrap();
    assert_eq!(reader.head().format, "svg");
    for (index, mask) in masks.iter().enumerate() {
        assert_eq!(&reader.layer(index as u32).unwrap().0, mask);
    }
}

#[test]
fn contradictions_are_named() {
    let print = print(5);
    let bytes = write(&SvgLayers, &print, &masks(&print.panel, 5, 1));
    for (change, says) in [
        (("viewBox=\"0 0 61 43\"", "viewBox=\"0 0 61 44\""), "viewBox"),
        (("M0 0h61v43h-61z", "M1 0h61v43h-61z"), "within the panel"),
        (("M0 0h61v43h-61z", "M0 0h61v4300000000h-61z"), "within the panel"),
        (("M0 0h61v43h-61z", "M0 0h61v43h-61zM3 3h1v1h-1z"), "overlapping"),
        (("M0 0h61v43h-61z", "M0 0L5 5z"), "rectangles"),
        (("fill=\"#ffffff\"", "fill=\"red\""), "fill"),
        (("</svg>", ""), "incomplete"),
        (("<path", "<circle"), "elements"),
    ] {
        let error = error_after(&bytes, "00001.svg", Some(change));
        assert!(error.contains(says), "{error}");
    }
}
