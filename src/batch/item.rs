//! The jobs of a batch, from what was typed.

use super::BatchError;
use super::inputs::{self, Found};
use super::manifest::{self, Line};
use super::names::{self, Wish};
use crate::job::FailureKind;
use crate::mesh::MeshError;
use crate::resin::Format;
use crate::settings::{PrinterTechnology, Settings, SettingsError, ValueError, keys, load_file};
use crate::slicer::profiles::Profiles;
use crate::slicer::{Failure, Request, Technology};
use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};

/// One job of a batch.
#[derive(Clone, Debug, PartialEq)]
pub struct Item {
    /// What is asked of a worker; its output is a path inside the output folder.
    pub request: Request,
    /// The output's name relative to the output folder, with `/`; unique in the batch. Stands for the job in reports.
    pub name: String,
    /// Size of the model's file \[bytes\]; 0 where it cannot be told.
    pub size: u64,
    /// Where the manifest names it: file and line; `None` for plain files.
    pub place: Option<(PathBuf, u64)>,
    /// What is wrong with it already: the job fails without a try.
    pub refused: Option<Failure>,
    /// SHA-256 of the model as the manifest has it, so that it need not be read to know its shard.
    pub sha256: Option<String>,
}

/// What a batch is made from.
#[derive(Clone, Debug)]
pub struct Input<'a> {
    /// Files, folders, patterns, manifests (`.jsonl`, `.csv`), as typed.
    pub inputs: &'a [String],
    /// What holds for every job that a manifest does not say otherwise.
    pub base: &'a Request,
    /// The output folder.
    pub folder: &'a Path,
    /// Extension of outputs; `None` = `gcode`, or what the printer reads.
    pub extension: Option<&'a str>,
}

/// All jobs, in the order given; files of folders and patterns by name.
///
/// # Errors
/// [`BatchError`]: an input that is not there, a manifest that cannot be understood, nothing to do. A model of
/// a manifest that is not there is no error here; its job fails.
pub fn items(input: &Input<'_>) -> Result<Vec<Item>, BatchError> {
    let folder = input.folder;
    if folder.to_str().is_none() {
        let source = io::Error::new(io::ErrorKind::InvalidInput, "its name is not UTF-8");
        return Err(BatchError::Input { path: folder.to_owned(), source });
    }
    let mut maker = Maker { input, profiles: Profiles::default(), resin_files: BTreeMap::new() };
    let (mut items, mut wishes) = (Vec::new(), Vec::new());
    for found in inputs::find(input.inputs, folder)? {
        match found {
            Found::Model(path) => {
                let (item, wish) = maker.plain(path)?;
                items.push(item);
                wishes.push(wish);
            }
            Found::Manifest(path) => {
                manifest::read(&path, &mut |line| {
                    let (item, wish) = maker.of_line(line, &path)?;
                    items.push(item);
                    wishes.push(wish);
                    Ok(())
                })?;
            }
        }
    }
    if items.is_empty() {
        return Err(BatchError::NoModels { input: input.inputs.join(", ") });
    }
    let names = names::unique(&wishes).map_err(|clash| twice(&items, &wishes, clash))?;
    for (item, name) in items.iter_mut().zip(names) {
        if !item.request.estimate {
            item.request.output = Some(folder.join(&name));
        }
        item.name = name;
    }
    Ok(items)
}

/// The technology that a request asks for where nobody says it: that of a named printer, of a format, of
/// settings given by key, of files of settings; `None` where none of them tells.
pub fn technology_of(request: &Request, format: Option<&str>) -> Option<Technology> {
    told(request.printer.as_deref(), format, &request.settings, &request.load, means_resin)
}

fn told(
    printer: Option<&str>,
    format: Option<&str>,
    settings: &BTreeMap<String, String>,
    load: &[PathBuf],
    mut means_resin: impl FnMut(&Path) -> bool,
) -> Option<Technology> {
    if printer.is_some() {
        return Some(Technology::Resin);
    }
    if let Some(format) = format {
        return Some(technology_of_format(format));
    }
    match settings.get("printer_technology").map(|v| v.trim()) {
        Some("SLA") => Some(Technology::Resin),
        Some("FFF") => Some(Technology::Filament),
        _ => load.iter().any(|path| means_resin(path)).then_some(Technology::Resin),
    }
}

fn technology_of_format(extension: &str) -> Technology {
    if names::is_gcode(extension) { Technology::Filament } else { Technology::Resin }
}

/// Whether a file of settings is one of a resin printer: filament settings refuse it for that reason.
fn means_resin(path: &Path) -> bool {
    matches!(
        load_file(path, &mut Settings::default()),
        Err(SettingsError::Value { error: ValueError::Bad { key: "printer_technology", value, .. }, .. })
            if value == "SLA"
    )
}

struct Maker<'a> {
    input: &'a Input<'a>,
    profiles: Profiles,
    /// Files of settings, and whether they are those of a resin printer.
    resin_files: BTreeMap<PathBuf, bool>,
}

impl Maker<'_> {
    /// The job of a plain file.
    fn plain(&self, model: PathBuf) -> Result<(Item, Wish), BatchError> {
        let mut request = Request { model, ..self.input.base.clone() };
        keep_own(&mut request.settings, request.technology);
        let extension = self.extension(&request, self.input.extension);
        let extension = extension.map_err(|failure| BatchError::Settings(failure.message))?;
        let wish = Wish::Model { stem: stem(&request), extension };
        Ok((item(request, None, None), wish))
    }

    /// The job of a line, or what is wrong with the line.
    fn of_line(&mut self, line: Line, manifest: &Path) -> Result<(Item, Wish), String> {
        let base = self.input.base;
        let mut request = base.clone();
        let place = Some((manifest.to_owned(), line.line));
        let own_printer = line.printer;
        let sha256 = line.sha256;
        request.copies = line.copies.unwrap_or(base.copies);
        request.orient = line.orient.unwrap_or(request.orient);
        request.match_tolerance = line.match_tolerance.or(base.match_tolerance);
        request.snap_grid = line.snap_grid.or(base.snap_grid);
        request.no_place = line.no_place.unwrap_or(base.no_place);
        request.support_enforcers = line.support_enforcers.unwrap_or(request.support_enforcers);
        request.support_blockers = line.support_blockers.unwrap_or(request.support_blockers);
        request.rotate = line.rotate.unwrap_or(base.rotate);
        request.check = line.check.unwrap_or(base.check);
        let known = &mut self.resin_files;
        let means_resin = |path: &Path| match known.get(path) {
            Some(resin) => *resin,
            None => *known.entry(path.to_owned()).or_insert(means_resin(path)),
        };
        let told = || {
            told(own_printer.as_deref(), line.format.as_deref(), &line.settings, &line.profile, means_resin)
        };
        request.technology = line.technology.or_else(told).unwrap_or(base.technology);
        keep_own(&mut request.settings, request.technology);
        request.model = line.model;
        request.load.extend(line.profile);
        request.settings.extend(line.settings);
        // The printer of the command line is for the resin jobs.
        let of_base = request.printer.filter(|_| request.technology == Technology::Resin);
        request.printer = own_printer.or(of_base);
        let fits = |extension: &&str| technology_of_format(extension) == request.technology;
        if let Some(format) = line.format.as_deref().filter(|f| !fits(f)) {
            return Err(format!(
                "format {format} and technology {} exclude each other",
                word(request.technology)
            ));
        }
        let format = line.format.as_deref().or(self.input.extension.filter(fits));
        if let Some(output) = line.output {
            let (name, refused) = self.named(output, &request, line.format.as_deref(), format)?;
            return Ok((Item { sha256, ..item(request, place, refused) }, Wish::Own(name)));
        }
        let (extension, refused) = self.extension_or_refusal(&request, format);
        let wish = Wish::Model { stem: stem(&request), extension };
        Ok((Item { sha256, ..item(request, place, refused) }, wish))
    }

    /// An output's name as given, with an extension where it had none.
    fn named(
        &self,
        output: String,
        request: &Request,
        own_format: Option<&str>,
        format: Option<&str>,
    ) -> Result<(String, Option<Failure>), String> {
        let Some(has) = names::extension(&output) else {
            let (extension, refused) = self.extension_or_refusal(request, format);
            let end = if extension.is_empty() { "/".to_owned() } else { format!(".{extension}") };
            return Ok((output + &end, refused));
        };
        if let Some(format) = own_format.filter(|f| *f != has) {
            return Err(format!("output \"{output}\" and format {format} exclude each other; leave one"));
        }
        let is_known = has.is_empty() || Format::of_extension(&has).is_some();
        match request.technology {
            Technology::Filament if has.is_empty() => Err(format!(
                "output \"{output}\" is a folder; G-code goes into a file, such as {output}a.gcode"
            )),
            Technology::Resin if !is_known => {
                let error = names::extension_of_format(&has).err().unwrap_or_default();
                Err(format!("output \"{output}\": {error}"))
            }
            _ => Ok((output, None)),
        }
    }

    /// The extension of a job's output, or a stand-in and why the job cannot be done.
    fn extension_or_refusal(&self, request: &Request, format: Option<&str>) -> (String, Option<Failure>) {
        match self.extension(request, format) {
            Ok(extension) => (extension, None),
            Err(failure) => ("zip".to_owned(), Some(failure)),
        }
    }

    fn extension(&self, request: &Request, format: Option<&str>) -> Result<String, Failure> {
        match (request.technology, format) {
            (Technology::Filament, format) => Ok(format.unwrap_or("gcode").to_owned()),
            (Technology::Resin, Some("")) => Ok(String::new()),
            (Technology::Resin, format) => {
                let settings = self.profiles.resolve(request)?.settings;
                let extension = settings.output_extension(format);
                extension.map(str::to_owned).map_err(|e| Failure::new(FailureKind::Settings, e.to_string()))
            }
        }
    }
}

fn item(mut request: Request, place: Option<(PathBuf, u64)>, refused: Option<Failure>) -> Item {
    let path = &request.model;
    let wrong = |e: MeshError| Some(Failure::new(FailureKind::Model, e.to_string()));
    let (size, missing) = match std::fs::metadata(path) {
        Ok(meta) => (if meta.is_file() { meta.len() } else { 0 }, None),
        Err(e) if e.kind() == io::ErrorKind::NotFound => {
            (0, wrong(MeshError::Missing { path: path.clone() }))
        }
        Err(source) => (0, wrong(MeshError::Read { path: path.clone(), source })),
    };
    let mut refused = missing.or(refused);
    if path.to_str().is_none() {
        // Neither a worker's line of JSON nor a report can hold it.
        let message = format!("{}: the name is not UTF-8; rename the file or its folder", path.display());
        refused = Some(Failure::new(FailureKind::Model, message));
        request.model = path.to_string_lossy().into_owned().into();
    }
    Item { request, name: String::new(), size, place, refused, sha256: None }
}

/// Leaves settings of the other technology out: the command line may have some for each.
fn keep_own(settings: &mut BTreeMap<String, String>, technology: Technology) {
    let own = match technology {
        Technology::Filament => PrinterTechnology::Fff,
        Technology::Resin => PrinterTechnology::Sla,
    };
    settings.retain(|key, _| keys::find(key).is_none_or(|k| k.technology.fits(own)));
}

/// Two lines that name one output.
fn twice(items: &[Item], wishes: &[Wish], clash: names::Clash) -> BatchError {
    let place = |i: usize| items.get(i).and_then(|item| item.place.clone()).unwrap_or_default();
    let ((first, first_line), (path, line)) = (place(clash.first), place(clash.second));
    let name = match wishes.get(clash.second) {
        Some(Wish::Own(name)) => name.as_str(),
        _ => "",
    };
    let problem = format!(
        "output \"{name}\" cannot be beside that of {}:{first_line}; give each job its own",
        first.display()
    );
    BatchError::Manifest { path, line, problem }
}

fn stem(request: &Request) -> String {
    request.model.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

fn word(technology: Technology) -> &'static str {
    match technology {
        Technology::Filament => "filament",
        Technology::Resin => "resin",
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use std::fs;

    struct Folder(tempfile::TempDir);

    impl Folder {
        fn new(files: &[(&str, &str)]) -> Self {
            let dir = tempfile::tempdir().unwrap();
            for (name, text) in files {
                let path = dir.path().join(name);
                fs::create_dir_all(path.parent().unwrap()).unwrap();
                fs::write(path, text).unwrap();
            }
            Self(dir)
        }

        fn at(&self, name: &str) -> PathBuf {
            self.0.path().join(name)
        }

        fn items(
            &self,
            inputs: &[&str],
            base: &Request,
            extension: Option<&str>,
        ) -> Result<Vec<Item>, BatchError> {
            let inputs: Vec<String> =
                inputs.iter().map(|i| self.at(i).to_str().unwrap().to_owned()).collect();
            items(&Input { inputs: &inputs, base, folder: &self.at("out"), extension })
        }

        fn names(&self, inputs: &[&str], base: &Request, extension: Option<&str>) -> Vec<String> {
            self.items(inputs, base, extension).unwrap().into_iter().map(|i| i.name).collect()
        }
    }

    fn resin() -> Request {
        Request {
            technology: Technology::Resin,
            printer: Some("elegoo-saturn-3-ultra".to_owned()),
            ..Request::default()
        }
    }

    #[test]
    fn files_folders_and_lines_become_jobs() {
        let dir = Folder::new(&[
            ("in/a.stl", "abc"),
            ("in/sub/A.stl", "abcd"),
            ("jobs.jsonl", "{\"model\": \"in/a.stl\"}\n{\"model\": \"in/a.stl\", \"output\": \"x/y\"}\n"),
        ]);
        let base = Request { date: 7, ..Request::default() };
        let items = dir.items(&["in", "in/a.stl", "jobs.jsonl"], &base, None).unwrap();
        let names: Vec<&str> = items.iter().map(|i| i.name.as_str()).collect();
        assert_eq!(names, ["a.gcode", "A-2.gcode", "a-3.gcode", "x/y.gcode"]);
        assert_eq!(items.iter().map(|i| i.size).collect::<Vec<_>>(), [3, 4, 3, 3]);
        let places: Vec<u64> = items.iter().map(|i| i.place.as_ref().map_or(0, |p| p.1)).collect();
        assert_eq!(places, [0, 0, 1, 2]);
        assert_eq!(items[3].request.output, Some(dir.at("out/x/y.gcode")));
        assert_eq!(items[3].request.model, dir.at("in/a.stl"));
        assert!(items.iter().all(|i| i.refused.is_none() && i.request.date == 7));
        let estimate = Request { estimate: true, ..base };
        let items = dir.items(&["in"], &estimate, None).unwrap();
        assert!(items.iter().all(|i| i.request.output.is_none()) && items[1].name == "A-2.gcode");
    }

    #[test]
    fn lines_say_more_than_the_command() {
        let dir = Folder::new(&[
            ("a.stl", ""),
            ("base.ini", "perimeters = 2\n"),
            ("sla.ini", "printer_technology = SLA\n"),
            (
                "jobs.csv",
                "model,profile,settings,copies,technology,printer,format,output\n\
                 a.stl,own.ini,skirts=2,3,,,,\n\
                 a.stl,,,,,prusa-sl1s,,\n\
                 a.stl,sla.ini,,,,,,\n\
                 a.stl,,,,resin,,goo,\n\
                 a.stl,,,,,,,b.gco\n",
            ),
        ]);
        let base = Request {
            load: vec![dir.at("base.ini")],
            settings: BTreeMap::from(
                [("skirts", "1"), ("perimeters", "5")].map(|(k, v)| (k.into(), v.into())),
            ),
            rotate: 4.0,
            ..Request::default()
        };
        let items = dir.items(&["jobs.csv"], &base, None).unwrap();
        let first = &items[0].request;
        assert_eq!(first.load, [dir.at("base.ini"), dir.at("own.ini")]);
        assert_eq!((first.settings["skirts"].as_str(), first.settings["perimeters"].as_str()), ("2", "5"));
        assert_eq!((first.copies, items[1].request.copies, first.rotate), (3, 1, 4.0));
        use Technology::{Filament, Resin};
        let technologies: Vec<Technology> = items.iter().map(|i| i.request.technology).collect();
        assert_eq!(technologies, [Filament, Resin, Resin, Resin, Filament]);
        let names: Vec<&str> = items.iter().map(|i| i.name.as_str()).collect();
        assert_eq!(names, ["a.gcode", "a.sl1s", "a.zip", "a.goo", "b.gco"]);
    }

    #[test]
    fn outputs_have_the_extension_that_the_printer_reads() {
        let dir = Folder::new(&[("a.stl", ""), ("b.stl", "")]);
        let both = ["a.stl", "b.stl"];
        assert_eq!(dir.names(&both, &resin(), None), ["a.goo", "b.goo"]);
        assert_eq!(dir.names(&both, &resin(), Some("zip")), ["a.zip", "b.zip"]);
        assert_eq!(dir.names(&both, &resin(), Some("")), ["a/", "b/"]);
        assert_eq!(dir.names(&both, &Request::default(), Some("gco")), ["a.gco", "b.gco"]);
        let locked = Request { printer: Some("elegoo-mars-3".to_owned()), ..resin() };
        let error = dir.items(&both, &locked, None).unwrap_err();
        assert!(error.exit_code() == 4 && error.to_string().contains("cannot be written"), "{error}");
        // In a manifest it is that line's trouble.
        let dir = Folder::new(&[
            ("a.stl", ""),
            ("jobs.csv", "model,printer\na.stl,elegoo-mars-3\na.stl,prusa-sl1\na.stl,no-such\n"),
        ]);
        let items = dir.items(&["jobs.csv"], &Request::default(), None).unwrap();
        let refused: Vec<_> = items.iter().map(|i| i.refused.as_ref().map(|f| f.kind)).collect();
        assert_eq!(refused, [Some(FailureKind::Settings), None, Some(FailureKind::Settings)]);
        assert_eq!(items[1].name, "a.sl1");
    }

    #[test]
    fn technologies_of_a_manifest_may_differ_from_the_command_s() {
        let dir = Folder::new(&[
            ("a.stl", ""),
            ("j.jsonl", "{\"model\": \"a.stl\", \"technology\": \"filament\"}\n{\"model\": \"a.stl\"}"),
        ]);
        let both = [("perimeters", "2"), ("exposure_time", "3"), ("layer_height", "0.1")];
        let settings = BTreeMap::from(both.map(|(k, v)| (k.to_owned(), v.to_owned())));
        let items = dir.items(&["j.jsonl"], &Request { settings, ..resin() }, Some("zip")).unwrap();
        let keys = |i: usize| items[i].request.settings.keys().cloned().collect::<Vec<_>>().join(" ");
        assert_eq!([keys(0), keys(1)], ["layer_height perimeters", "exposure_time layer_height"]);
        assert_eq!((items[0].request.printer.as_deref(), items[0].name.as_str()), (None, "a.gcode"));
        assert_eq!((items[1].request.printer.is_some(), items[1].name.as_str()), (true, "a.zip"));
    }

    #[test]
    fn models_that_are_not_there_fail_alone() {
        let dir = Folder::new(&[("a.stl", ""), ("j.csv", "model\nnone.stl\na.stl\n")]);
        let items = dir.items(&["j.csv"], &Request::default(), None).unwrap();
        let refused = items[0].refused.as_ref().unwrap();
        assert_eq!(refused.kind, FailureKind::Model);
        assert!(refused.message.ends_with("none.stl: no such file; check the path"));
        assert!(items[1].refused.is_none());
        let error = dir.items(&["none.stl"], &Request::default(), None).unwrap_err();
        assert_eq!(error.exit_code(), 3, "typed by hand it is a mistake");
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn names_that_are_no_text_fail_alone() {
        use std::os::unix::ffi::OsStrExt;
        let dir = Folder::new(&[("in/a.stl", "")]);
        fs::write(dir.at("in").join(std::ffi::OsStr::from_bytes(b"b\xff.stl")), "").unwrap();
        let items = dir.items(&["in"], &Request::default(), None).unwrap();
        assert!(items[1].refused.as_ref().unwrap().message.contains("not UTF-8"), "{items:?}");
        assert!(serde_json::to_string(&items[1].request).is_ok());
        assert_eq!(items[1].name, "b\u{fffd}.gcode");
    }

    #[test]
    fn what_cannot_be_meant_is_refused() {
        let refused = |lines: &str| {
            let dir = Folder::new(&[("a.stl", ""), ("j.csv", lines)]);
            let error = dir.items(&["j.csv"], &Request::default(), None).unwrap_err();
            assert_eq!(error.exit_code(), 4, "{error}");
            error.to_string()
        };
        let error = refused("model,output\na.stl,x.gcode\na.stl,\na.stl,X.gcode\n");
        assert!(error.contains("j.csv:4: output \"X.gcode\" cannot be beside that of "), "{error}");
        assert!(error.contains("j.csv:2; give each job its own"), "{error}");
        for (lines, message) in [
            (
                "model,format,technology\na.stl,goo,filament\n",
                "j.csv:2: format goo and technology filament exclude",
            ),
            ("model,format,output\na.stl,goo,a.zip\n", "j.csv:2: output \"a.zip\" and format goo exclude"),
            (
                "model,technology,output\na.stl,resin,a.xyz\n",
                "j.csv:2: output \"a.xyz\": no format has the extension",
            ),
            ("model,output\na.stl,x/\n", "j.csv:2: output \"x/\" is a folder"),
        ] {
            let error = refused(lines);
            assert!(error.contains(message) && error.lines().count() == 1, "{error}");
        }
        let dir = Folder::new(&[("empty.jsonl", "\n"), ("none/readme.txt", "")]);
        for input in ["empty.jsonl", "none"] {
            let error = dir.items(&[input], &Request::default(), None).unwrap_err();
            assert!(matches!(error, BatchError::NoModels { .. }) && error.exit_code() == 3);
        }
    }
}
