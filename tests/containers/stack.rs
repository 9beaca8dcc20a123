use crate::zipped::*;
use microtome::resin::layer_files::{open_folder, open_zip};
use microtome::resin::stack::PngStack;
use std::fs;
use std::io::Cursor;

#[test]
fn comes_back() {
    round_trip(&PngStack);
}

#[test]
fn damage_is_noticed() {
    damage(&PngStack);
}

#[test]
fn folders_come_back() {
    let print = print(6);
    let masks = masks(&print.panel, 6, 5);
    let folder = tempfile::tempdir().unwrap();
    fill(&PngStack, PngStack.begin_folder(folder.path(), &print).unwrap(), &print, &masks);
    let mut names: Vec<_> =
        fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    assert_eq!(names[..2], ["00000.png", "00001.png"]);
    assert_eq!(names[6..], ["manifest.json", "preview.png", "settings.ini"]);
    let mut reader = open_folder(folder.path()).unwrap();
    for (index, mask) in masks.iter().enumerate() {
        let (read, told) = reader.layer(index as u32).unwrap();
        assert_eq!(&read, mask);
        let expected = info(&print, mask, index as u32);
        assert_eq!((told.z, told.exposure, told.lit), (expected.z, expected.exposure, expected.lit));
    }
    fs::remove_file(folder.path().join("00002.png")).unwrap();
    assert!(reader.layer(2).is_err() && reader.layer(3).is_ok());
    assert!(open_folder(folder.path()).is_err());
    let manifest = folder.path().join("manifest.json");
    let text = fs::read_to_string(&manifest).unwrap();
    fs::write(&manifest, text.replace("00002.png", "../00001.png")).unwrap();
    let error = open_folder(folder.path()).map(|_| ()).unwrap_err().to_string();
    assert!(error.contains("../00001.png"), "nothing outside the folder is read: {error}");
    fs::remove_file(manifest).unwrap();
    assert!(open_folder(folder.path()).is_err());
}

#[test]
fn the_archive_is_one_that_uvtools_knows() {
    let print = print(11);
    let bytes = write(&PngStack, &print, &masks(&print.panel, 11, 1));
    let names: Vec<_> = members(&bytes).into_iter().map(|(name, _)| name).collect();
    let numbers: Vec<u32> =
        names.iter().filter_map(|n| n.strip_suffix(".png")).filter_map(|n| n.parse().ok()).collect();
    assert_eq!(numbers, (1..=11).collect::<Vec<_>>());
    let manifest = members(&bytes).into_iter().find(|(n, _)| n == "manifest.uvtools").unwrap().1;
    let manifest = String::from_utf8(manifest).unwrap();
    assert!(manifest.contains("<ResolutionX>61</ResolutionX>"), "{manifest}");
    assert!(manifest.contains("<CreatedDate>2023-11-14 22:13:21Z</CreatedDate>"), "{manifest}");
}

#[test]
fn contradictions_are_named() {
    let print = print(5);
    let bytes = write(&PngStack, &print, &masks(&print.panel, 5, 1));
    for (member, change, says) in [
        ("manifest.json", Some(("\"version\": 1", "\"version\": 2")), "version 2"),
        ("manifest.json", Some(("\"width_px\": 61", "\"width_px\": 4294967295")), "the panel"),
        ("manifest.json", Some(("\"width_px\": 61", "\"width_px\": -1")), "manifest.json"),
        ("manifest.json", Some(("\"width_px\": 61", "\"width_px\": 99")), "expected 99 x 43"),
        ("manifest.json", Some(("\"layer_format\": \"png\"", "\"layer_format\": \"gif\"")), "layer_format"),
        ("4.png", None, "4.png"),
    ] {
        let error = error_after(&bytes, member, change);
        assert!(error.contains(says), "{error}");
    }
    let foreign = archive(&[("mimetype".to_owned(), b"none".to_vec())]);
    for bytes in [foreign, Vec::new(), b"PK\x03\x04".to_vec(), b"solid stl".to_vec()] {
        let error = open_zip(Box::new(Cursor::new(bytes))).map(|_| ()).unwrap_err().to_string();
        assert!(error.contains("known") || error.contains("truncated"), "{error}");
    }
}
