//! The kill test: a child process paints and saves without pause and is killed at random moments; every stroke that it reported
//! is found again. `BALAYAGE_KILLS` sets the number of kills (15).

use std::{
    env,
    io::{BufRead, BufReader, Write},
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
    thread::sleep,
    time::Duration,
};

use balayage::{
    document::{
        Answers, Document, Edit, JournalAnswer, OpenStep, Project, Question, SaveOptions, Source, UserState,
        open_step, recover,
    },
    paint::OperationId,
};
use balayage_tests::random;
use rand::Rng;

use crate::{journal::stroke, project::sample};

/// Names the project to the child.
const PROJECT: &str = "BALAYAGE_KILL_PROJECT";
/// Kills of one project before the next begins anew.
const CHAIN: usize = 10;

/// Opens a project as the editor does, taking whatever a journal holds.
fn open(path: &Path) -> Document {
    let state = UserState::in_folder(path.parent().unwrap().join("state"));
    let mut answers = Answers::default();
    loop {
        match open_step(&Source::File(path.to_owned()), &answers, &state).unwrap() {
            OpenStep::Opened(opened) => return opened.document,
            OpenStep::Ask(Question::Recover(summary)) => {
                answers.journal = Some(JournalAnswer::Recover(summary.journal));
            }
            OpenStep::Ask(question) => panic!("{question:?}"),
        }
    }
}

/// The process that is killed: no test without its variable.
#[test]
fn child() {
    let Some(path) = env::var_os(PROJECT).map(PathBuf::from) else {
        return;
    };
    let mut document = open(&path);
    let say = |line: &str| {
        let mut out = std::io::stdout().lock();
        // The one who listens may have gone with the kill.
        let _ = writeln!(out, "{line}").and_then(|()| out.flush());
    };
    say("ready");
    for count in 1.. {
        let number = document.next_operation_number();
        document.apply(Edit::Stroke(stroke(number, "paint"))).unwrap();
        if let Some(problem) = document.take_journal_problem() {
            say(&format!("problem {problem}"));
            return;
        }
        say(&format!("stroke {number}"));
        if count % 25 == 0 {
            let options = SaveOptions {
                backups: 2,
                ..SaveOptions::default()
            };
            document.save_with(&path, options, |_| Ok(())).unwrap();
        }
    }
}

fn start(path: &Path) -> Child {
    Command::new(env::current_exe().unwrap())
        .args(["kill::child", "--exact", "--nocapture"])
        .env(PROJECT, path)
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap()
}

/// What the next start would open.
fn left(path: &Path) -> Project {
    let state = path.parent().unwrap().join("state");
    let journals = recover::journals_of(Some(path), &state);
    assert!(journals.len() <= 1, "{} journals", journals.len());
    match journals.first() {
        Some(contents) => recover::recover(contents, Some(path), false).unwrap().project,
        None => Document::open(path, None).unwrap().document.project().clone(),
    }
}

fn numbers(project: &Project) -> Vec<u64> {
    let numbers = project.operations.iter().map(|operation| match operation.id {
        OperationId::Number(number) => number,
        OperationId::Text(_) => panic!("a name"),
    });
    numbers.collect()
}

#[test]
fn no_reported_stroke_is_lost_by_a_kill() {
    let kills: usize = env::var("BALAYAGE_KILLS").map_or(15, |text| text.parse().unwrap());
    let mut random = random(11);
    let mut folder = tempfile::tempdir().unwrap();
    let mut path = sample(folder.path());
    let (mut reported, mut torn, mut in_flight) = (0, 0, 0);
    for kill in 0..kills {
        if kill % CHAIN == 0 {
            folder = tempfile::tempdir().unwrap();
            path = sample(folder.path());
            reported = 0;
        }
        let mut child = start(&path);
        let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
        let ready = lines
            .by_ref()
            .map_while(Result::ok)
            .any(|line| line.ends_with("ready"));
        assert!(ready, "the child did not start");
        sleep(Duration::from_micros(random.random_range(0..120_000)));
        child.kill().unwrap();
        child.wait().unwrap();
        for line in lines.map_while(Result::ok) {
            let number = line.strip_prefix("stroke ").unwrap_or_else(|| panic!("{line}"));
            // A line may have been cut by the kill.
            reported = number.parse::<u64>().unwrap().max(reported);
        }

        // All that was reported is there, in order, and at most the one stroke more that was not yet reported.
        let state = path.parent().unwrap().join("state");
        torn += recover::journals_of(Some(&path), &state)
            .iter()
            .filter(|contents| contents.torn_bytes > 0)
            .count();
        let found = numbers(&left(&path));
        let last = found.len() as u64;
        assert!(found == (1..=last).collect::<Vec<_>>(), "kill {kill}: {found:?}");
        assert!(
            last == reported || last == reported + 1,
            "kill {kill}: {reported} reported, {last} found"
        );
        in_flight += last - reported;
        reported = last;
    }
    println!(
        "{kills} kills, {torn} torn journals, {in_flight} strokes kept that were not yet reported, 0 lost"
    );
}

/// Says how a rendering ends that finds no adapter: no test without its variable.
#[test]
fn child_without_gpu() {
    let Some(picture) = env::var_os(PICTURE) else {
        return;
    };
    let args = ["balayage", "render", "--size", "8x8", "-o"].map(Into::into);
    let (mut out, mut err) = (Vec::new(), Vec::new());
    let code = balayage::cli::run(args.into_iter().chain([picture]), &mut out, &mut err);
    std::io::stderr().write_all(&err).unwrap();
    std::process::exit(code.into());
}

/// Names the picture to the child.
const PICTURE: &str = "BALAYAGE_NO_GPU_PICTURE";

#[test]
fn without_an_adapter_the_exit_code_is_three() {
    let folder = tempfile::tempdir().unwrap();
    let run = |hides: bool| {
        let mut command = Command::new(env::current_exe().unwrap());
        command
            .args(["kill::child_without_gpu", "--exact", "--nocapture"])
            .env(PICTURE, folder.path().join("p.png"))
            .stdout(Stdio::null());
        if hides {
            for variable in ["VK_ICD_FILENAMES", "VK_DRIVER_FILES"] {
                command.env(variable, "/nonexistent");
            }
            command.env("WGPU_BACKEND", "vulkan");
        }
        let output = command.output().unwrap();
        (
            output.status.code(),
            String::from_utf8_lossy(&output.stderr).into_owned(),
        )
    };
    let (code, said) = run(true);
    assert!(
        code == Some(3) && said.contains("install a Vulkan driver"),
        "{code:?} {said}"
    );
    assert!(!folder.path().join("p.png").exists());
}
