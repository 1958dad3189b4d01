//! Questions that hold up opening and saving: what only the person can decide.

use std::path::{Path, PathBuf};

use egui::{Context, Modal, Ui};

use super::{Editor, actions::DialogAnswer};
use crate::document::{
    Answers, Holder, JournalAnswer, LockAnswer, MAX_BACKUPS, Question,
    recover::{self, Summary},
    relink::{Missing, Role},
};

/// What the person is asked.
#[derive(Clone, Debug)]
pub(super) enum Asking {
    /// On the way to a document.
    Opening(Question),
    /// The file to be saved was changed by another program.
    Conflict(PathBuf),
}

/// What a button of a question does.
enum Choice {
    /// Opening goes on with these answers.
    GoOn(Answers),
    /// The journal goes, and opening goes on.
    Discard(PathBuf),
    /// The person shows where the file is.
    Find(Role),
    /// The other program's version is overwritten.
    Overwrite(PathBuf),
    SaveAs,
    /// The other program's version is opened instead.
    Reload(PathBuf),
    Cancel,
}

impl Editor {
    /// Shows the question that waits for an answer.
    pub(super) fn question_dialog(&mut self, context: &Context) {
        let Some(asking) = self.asking.clone() else { return };
        let answers = self.request.1.clone();
        let shown = Modal::new(egui::Id::unique("question")).show(context, |ui| {
            ui.set_width(460.0);
            match &asking {
                Asking::Opening(Question::Recover(summary)) => ask_to_recover(ui, summary, &answers),
                Asking::Opening(Question::Locked { holder, may_be_stale }) => {
                    ask_about_lock(ui, holder, *may_be_stale, &answers)
                }
                Asking::Opening(Question::Outside(files)) => ask_to_trust(ui, files, answers),
                Asking::Opening(Question::Missing(missing)) => ask_for_missing(ui, missing, answers),
                Asking::Conflict(path) => ask_about_conflict(ui, path),
            }
        });
        let is_dismissed = shown.should_close();
        let choice = shown.inner.or(is_dismissed.then_some(Choice::Cancel));
        if let Some(choice) = choice {
            self.choose(context, choice);
        }
    }

    fn choose(&mut self, context: &Context, choice: Choice) {
        // A file dialog may be cancelled: then the question is still there.
        if let Choice::Find(role) = choice {
            let (what, extensions): (_, &[&str]) = match role {
                Role::Groom => ("Grooms", &["hair", "tfx", "usda", "usdc", "usd"]),
                Role::Head => ("Heads", &["obj"]),
                Role::Light => ("Lights", &["hdr", "exr", "json"]),
            };
            return self.ask_for_file(context, what, extensions, move |path| {
                DialogAnswer::Link(role, path)
            });
        }
        self.asking = None;
        let source = self.request.0.clone();
        match choice {
            Choice::GoOn(answers) => self.start_opening(context, source, answers),
            Choice::Discard(journal) => match recover::discard(&journal) {
                Ok(()) => {
                    let answers = self.request.1.clone();
                    self.start_opening(context, source, answers);
                }
                Err(problem) => self.complain(&problem),
            },
            Choice::Overwrite(path) => self.save(context, &path, true),
            Choice::SaveAs => self.ask_where_to_save(context),
            Choice::Reload(path) => {
                self.after_save = None;
                self.open(context, path);
            }
            Choice::Find(_) | Choice::Cancel => {
                self.after_save = None;
                // Without a document there is nothing to look at.
                if self.document.is_none() && self.opening.is_none() {
                    self.start_opening(
                        context,
                        crate::document::Source::Sample,
                        Answers {
                            journal: Some(JournalAnswer::Later),
                            ..Answers::default()
                        },
                    );
                }
            }
        }
    }

    /// How many versions of a project are kept beside it.
    pub(super) fn backups_setting(&mut self, ui: &mut Ui) {
        ui.separator();
        ui.horizontal(|ui| {
            let label = ui.label("Backups");
            let mut backups = self.state.backups();
            let field = ui.add(egui::DragValue::new(&mut backups).range(0..=MAX_BACKUPS));
            let hint = "Earlier versions that are kept beside a project: NAME.json.1~ is the newest";
            if field.labelled_by(label.id).on_hover_text(hint).changed()
                && let Err(problem) = self.state.set_backups(backups)
            {
                self.complain(&problem);
            }
        });
    }
}

/// The buttons of a question; the choice of the one that was clicked.
fn buttons(ui: &mut Ui, choices: Vec<(&str, Choice)>) -> Option<Choice> {
    ui.add_space(8.0);
    ui.horizontal_wrapped(|ui| {
        let mut chosen = None;
        for (name, choice) in choices {
            if ui.button(name).clicked() {
                chosen = Some(choice);
            }
        }
        chosen
    })
    .inner
}

fn ask_to_recover(ui: &mut Ui, summary: &Summary, answers: &Answers) -> Option<Choice> {
    ui.heading("Work that was not saved");
    let name = match &summary.project {
        Some(project) => project.display().to_string(),
        None => "A project without a name".to_owned(),
    };
    ui.label(format!(
        "{name}: the last session ended unexpectedly. It left {summary}."
    ));
    ui.weak(summary.journal.display().to_string());
    let with = |journal| {
        Choice::GoOn(Answers {
            journal: Some(journal),
            ..answers.clone()
        })
    };
    let mut choices = Vec::new();
    if summary.content.is_ok() {
        let recover = JournalAnswer::Recover(summary.journal.clone());
        choices.push(("Recover", with(recover)));
    }
    choices.push(("Keep for later", with(JournalAnswer::Later)));
    choices.push(("Discard", Choice::Discard(summary.journal.clone())));
    buttons(ui, choices)
}

fn ask_about_lock(ui: &mut Ui, holder: &Holder, may_be_stale: bool, answers: &Answers) -> Option<Choice> {
    ui.heading("The project is open elsewhere");
    ui.label(format!(
        "{holder} has it open. Two that save it would overwrite each other."
    ));
    if may_be_stale {
        ui.label("That computer cannot be asked from here: take over only if Balayage no longer runs there.");
    }
    let with = |lock| {
        Choice::GoOn(Answers {
            lock: Some(lock),
            ..answers.clone()
        })
    };
    let mut choices = vec![("Open a copy", with(LockAnswer::Copy))];
    if may_be_stale {
        choices.push(("Take over", with(LockAnswer::TakeOver)));
    }
    choices.push(("Cancel", Choice::Cancel));
    buttons(ui, choices)
}

/// Lines of a list that are shown.
const SHOWN: usize = 6;

fn ask_to_trust(ui: &mut Ui, files: &[PathBuf], answers: Answers) -> Option<Choice> {
    ui.heading("Files outside the project's folder");
    ui.label("The project names files elsewhere. Read them only if you trust where it comes from; their folders are remembered.");
    for file in files.iter().take(SHOWN) {
        ui.monospace(file.display().to_string());
    }
    if files.len() > SHOWN {
        ui.weak(format!("and {} more", files.len() - SHOWN));
    }
    let trusting = Answers {
        trusts_outside: true,
        ..answers
    };
    buttons(
        ui,
        vec![("Read them", Choice::GoOn(trusting)), ("Cancel", Choice::Cancel)],
    )
}

fn ask_for_missing(ui: &mut Ui, missing: &[Missing], answers: Answers) -> Option<Choice> {
    ui.heading("Files are missing");
    ui.label(
        "They are not where the project says, and none with their content is near it or in recent folders.",
    );
    let mut choices = Vec::new();
    for missing in missing {
        ui.monospace(format!("{}: {}", missing.role.name(), missing.path.display()));
        let name = match missing.role {
            Role::Groom => "Find groom…",
            Role::Head => "Find head…",
            Role::Light => "Find light…",
        };
        choices.push((name, Choice::Find(missing.role)));
    }
    if missing.iter().all(|missing| missing.role != Role::Groom) {
        let without = Answers {
            goes_without: true,
            ..answers
        };
        choices.push(("Open without", Choice::GoOn(without)));
    }
    choices.push(("Cancel", Choice::Cancel));
    buttons(ui, choices)
}

fn ask_about_conflict(ui: &mut Ui, path: &Path) -> Option<Choice> {
    ui.heading("The file has changed");
    ui.label(format!(
        "{} was changed by another program since it was opened.",
        path.display()
    ));
    ui.weak("Overwriting keeps that version as the newest backup; opening it again gives up the changes made here.");
    buttons(
        ui,
        vec![
            ("Overwrite", Choice::Overwrite(path.to_owned())),
            ("Save as…", Choice::SaveAs),
            ("Open it again", Choice::Reload(path.to_owned())),
            ("Cancel", Choice::Cancel),
        ],
    )
}
