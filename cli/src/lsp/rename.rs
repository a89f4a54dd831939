//! Another name for something, in all files of a project.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use kinora_lang::ide::{Analysis, Place, is_name};
use kinora_lang::library;
use kinora_lang::source::Span;

use super::project::{Open, Project, is_standard};

/// The places that get the name, by file.
pub type Places = BTreeMap<Arc<str>, Vec<Span>>;

/// Where the name at an offset can be changed: the name there.
///
/// # Errors
/// There is no name, or it is one that this program gives.
pub fn prepare(analysis: &Analysis, project: &Project, offset: u32) -> Result<(Span, Place), String> {
    let found = analysis.word_at(offset).ok_or("there is no name here that can be changed")?;
    if library::is_path(&found.1.file) || project.path(&found.1.file).is_some_and(|path| is_standard(&path)) {
        return Err(format!("`{}` is part of this program", found.1.file));
    }
    // A name in quotes may hold what no other name can.
    let quoted = analysis.tree.source.slice(found.0).starts_with('"');
    match quoted {
        true => Err("a name in quotes is changed by hand".into()),
        false => Ok(found),
    }
}

/// The places that change when what is declared at `declared` is called `new`.
///
/// # Errors
/// The new name is none, or something would then mean something else.
pub fn rename(project: &Project, open: &Open, declared: &Place, new: &str) -> Result<Places, String> {
    if !is_name(new) {
        return Err(format!("`{new}` cannot be a name: letters, digits and `_`, and no word of the language"));
    }
    let mut places = Places::new();
    for place in project.references(open, declared, true) {
        places.entry(place.file).or_default().push(place.span);
    }
    let mut texts: Open = BTreeMap::new();
    for (file, spans) in &places {
        let source = project.source(file).ok_or_else(|| format!("cannot read `{file}`"))?;
        let text = replaced(&source.text, spans, new);
        texts.insert(project.path(file).unwrap_or_else(|| PathBuf::from(&**file)), text.into_bytes().into());
    }
    verify(project, open, &places, texts, new)?;
    Ok(places)
}

fn replaced(text: &str, spans: &[Span], new: &str) -> String {
    let (mut result, mut at) = (String::with_capacity(text.len()), 0);
    for span in spans {
        let (start, end) = (span.start as usize, span.end as usize);
        result += text.get(at..start).unwrap_or_default();
        result += new;
        at = end;
    }
    result + text.get(at..).unwrap_or_default()
}

/// Whether every name of the project means what it did.
fn verify(project: &Project, open: &Open, places: &Places, texts: Open, new: &str) -> Result<(), String> {
    let mut all = open.clone();
    all.extend(texts);
    let after = Project::of(&project.root().join(project.name()), &all);
    let now = |place: &Place| -> Place {
        let Some(spans) = places.get(&place.file) else { return place.clone() };
        let moved = |offset: u32| {
            let before = spans.iter().filter(|span| span.end <= offset);
            let grown: i64 = before.map(|span| new.len() as i64 - i64::from(span.len())).sum();
            (i64::from(offset) + grown).max(0) as u32
        };
        Place { file: place.file.clone(), span: Span::new(moved(place.span.start), moved(place.span.end)) }
    };
    for file in project.scenes(open) {
        let (Some(before), Some(after)) = (project.analyse(&file), after.analyse(&file)) else { continue };
        if !before.means_the_same(&after, &now) {
            return Err(format!(
                "`{new}` already means something in `{file}`, so that names would change their meaning"
            ));
        }
    }
    Ok(())
}
