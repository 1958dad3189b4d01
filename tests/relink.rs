//! Files that moved, files that changed, files that are none of the project's business.

use std::{fs, path::Path};

use balayage::document::{
    Answers, Document, Environment, OpenStep, Project, Question, Source, UserState, open_step,
    relink::{self, Role},
};
use balayage_render::groom::write_groom;

use crate::{cli::balayage, painting::tuft, project::sample};

/// A saved project with a light list beside it.
fn saved(folder: &Path) -> std::path::PathBuf {
    let path = sample(folder);
    fs::create_dir(folder.join("lights")).unwrap();
    let lights = r#"{"lights": [], "constant": [0.5, 0.5, 0.5]}"#;
    fs::write(folder.join("lights/even.json"), lights).unwrap();
    let text = fs::read_to_string(&path).unwrap();
    let lit = text.replace(
        "\"version\": 1",
        r#""version": 1, "light": {"environment": {"lights": "lights/even.json"}}"#,
    );
    fs::write(&path, lit).unwrap();
    let mut document = Document::open(&path, None).unwrap().document;
    document.save_as(&path).unwrap();
    assert_eq!(document.project().files.len(), 1);
    path
}

#[test]
fn moved_files_are_found_by_their_content() {
    let folder = tempfile::tempdir().unwrap();
    let path = saved(folder.path());
    // Moved and renamed; beside them others of the same kind.
    let new = folder.path().join("assets/hair");
    fs::create_dir_all(&new).unwrap();
    fs::rename(folder.path().join("grooms/tuft.hair"), new.join("brown.hair")).unwrap();
    fs::rename(folder.path().join("lights/even.json"), new.join("studio.json")).unwrap();
    fs::write(folder.path().join("grooms/tuft.tfx"), "no groom").unwrap();
    fs::write(folder.path().join("grooms/other.hair"), "no groom").unwrap();
    let opened = Document::open(&path, None).unwrap();
    assert_eq!(opened.warnings.len(), 2, "{:?}", opened.warnings);
    assert!(opened.warnings[0].contains("brown.hair") && opened.warnings[0].contains("same content"));
    assert_eq!(opened.document.project().groom.path, "assets/hair/brown.hair");
    let lights = Environment::Lights("assets/hair/studio.json".into());
    assert!(opened.document.project().light.environment == lights && opened.document.is_modified());

    // The command does it for good.
    let (code, out, err) = balayage(&["relink", path.to_str().unwrap()]);
    assert!(code == 0 && out.contains("brown.hair"), "{out}{err}");
    assert!(Document::open(&path, None).unwrap().warnings.is_empty());
}

#[test]
fn missing_files_are_asked_for_and_other_content_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let path = saved(folder.path());
    let elsewhere = tempfile::tempdir().unwrap();
    let moved = elsewhere.path().join("tuft.hair");
    fs::rename(folder.path().join("grooms/tuft.hair"), &moved).unwrap();
    let problem = Document::open(&path, None).map(drop).unwrap_err();
    assert!(
        problem.file.ends_with("tuft.hair") && problem.remedy.contains("relink"),
        "{problem}"
    );

    // The editor asks; a folder that was used lately is searched first.
    let mut state = UserState::in_folder(folder.path().join("state"));
    let source = Source::File(path.clone());
    let asked = open_step(&source, &Answers::default(), &state).unwrap();
    assert!(matches!(asked, OpenStep::Ask(Question::Missing(missing)) if missing.len() == 1));
    state.remember(std::slice::from_ref(&moved), &[]).unwrap();
    let again = UserState::in_folder(folder.path().join("state"));
    let found = open_step(&source, &Answers::default(), &again).unwrap();
    assert!(matches!(found, OpenStep::Opened(opened) if opened.document.is_modified()));

    // Another groom can be named; what that means is said.
    let other = elsewhere.path().join("other.hair");
    let shorter = tuft();
    let strands = (0..100).map(|s| &shorter.positions()[shorter.strand(s)]);
    let (other_groom, _) = balayage_render::groom::Groom::from_strands(strands, 0.008, 0.01).unwrap();
    write_groom(&other, &other_groom).unwrap();
    let answers = Answers {
        files: vec![(Role::Groom, other.clone())],
        trusts_outside: true,
        ..Answers::default()
    };
    let fresh = UserState::in_folder(folder.path().join("fresh"));
    let OpenStep::Opened(opened) = open_step(&source, &answers, &fresh).unwrap() else {
        panic!("asked");
    };
    assert!(
        opened.warnings.iter().any(|w| w.contains("recorded places")),
        "{:?}",
        opened.warnings
    );
    drop(opened);
    let args = [
        "relink",
        path.to_str().unwrap(),
        "--groom",
        other.to_str().unwrap(),
    ];
    let (code, _, err) = balayage(&args);
    assert!(code == 0 && err.contains("not that of the groom"), "{err}");
    let (code, _, err) = balayage(&["relink", path.to_str().unwrap(), "--groom", "nowhere.hair"]);
    assert!(code == 1 && err.contains("nowhere.hair"), "{err}");
    let (code, _, err) = balayage(&[
        "relink",
        path.to_str().unwrap(),
        "--head",
        other.to_str().unwrap(),
    ]);
    assert!(code == 1 && err.contains("names no file as its head"), "{err}");
}

#[test]
fn files_outside_the_folder_are_read_with_leave_only() {
    let folder = tempfile::tempdir().unwrap();
    let inside = folder.path().join("project");
    fs::create_dir(&inside).unwrap();
    let path = sample(&inside);
    let text = fs::read_to_string(&path).unwrap();
    let outside = |text: &str| {
        let project = Project::parse(text).unwrap();
        relink::outside_files(&project, &inside)
    };
    assert!(outside(&text).is_empty());
    for reference in ["../tuft.hair", "/etc/passwd", "grooms/../../tuft.hair"] {
        let text = text.replace("grooms/tuft.hair", reference);
        assert_eq!(outside(&text).len(), 1, "{reference}");
    }
    assert!(outside(&text.replace("grooms/tuft.hair", "x/../grooms/tuft.hair")).is_empty());
    let sequence = r#""version": 1, "light": {"environment": {"sequence": {"maps": ["a.hdr", "../b.hdr"]}}}"#;
    assert_eq!(outside(&text.replace("\"version\": 1", sequence)).len(), 1);
    #[cfg(unix)]
    {
        fs::rename(inside.join("grooms/tuft.hair"), folder.path().join("tuft.hair")).unwrap();
        std::os::unix::fs::symlink(folder.path().join("tuft.hair"), inside.join("grooms/tuft.hair")).unwrap();
        assert_eq!(outside(&text).len(), 1, "a link that leads out");
        fs::remove_file(inside.join("grooms/tuft.hair")).unwrap();
    }

    // The editor asks once for a folder; the command line tells.
    fs::write(&path, text.replace("grooms/tuft.hair", "../tuft.hair")).unwrap();
    let mut state = UserState::in_folder(folder.path().join("state"));
    let source = Source::File(path.clone());
    let asked = open_step(&source, &Answers::default(), &state).unwrap();
    assert!(matches!(asked, OpenStep::Ask(Question::Outside(files)) if files.len() == 1));
    let trusting = Answers {
        trusts_outside: true,
        ..Answers::default()
    };
    let OpenStep::Opened(opened) = open_step(&source, &trusting, &state).unwrap() else {
        panic!("asked again");
    };
    let (used, trusted) = opened.document.used_files();
    assert_eq!((used.len(), trusted.len()), (2, 1));
    state.remember(&used, &trusted).unwrap();
    drop(opened);
    let again = open_step(&source, &Answers::default(), &state).unwrap();
    assert!(matches!(again, OpenStep::Opened(_)));
    drop(again);
    let (code, _, err) = balayage(&["check", path.to_str().unwrap()]);
    assert!(code == 0 && err.contains("outside its folder"), "{err}");
}
