//! `kinora diff`: how much two pictures differ.

use std::path::PathBuf;

use serde::Serialize;

use crate::encode::Target;
use crate::exit::{self, Outcome};
use crate::likeness::{Difference, Picture, Shown, page, sizes};
use crate::terminal;

/// Compare two pictures, by FLIP and by the relative error of their light.
///
/// Ends with 0 if they are as alike as asked for, with 1 if they are not, and with 2 if they cannot be compared.
///
/// Example: kinora diff before.png after.png --html diff.html
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The reference: .png, .jpg, .exr or .hdr
    reference: PathBuf,
    /// What is compared with it
    picture: PathBuf,
    /// How much they may differ, as the mean of FLIP [default: not at all]
    #[arg(long, value_name = "0..1", value_parser = share)]
    flip: Option<f64>,
    /// How much their light may differ, as the mean of (picture − reference)² / (reference² + 0.01)
    #[arg(long, value_name = "LIMIT", value_parser = limit)]
    error: Option<f64>,
    /// Write a page that shows both, and where they differ
    #[arg(long, value_name = "FILE.html")]
    html: Option<PathBuf>,
    /// Write where they differ as a picture
    #[arg(short, long, value_name = "FILE.png")]
    output: Option<PathBuf>,
    /// Print the numbers on stdout, as one line of JSON
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Numbers {
    flip: Option<f64>,
    error: Option<f64>,
    same: bool,
    said: String,
}

pub fn run(args: &Args) -> Outcome {
    let targets = [&args.html, &args.output].map(|path| path.as_deref().map(Target::new).transpose());
    let [html, output] = targets;
    let (html, output) = (html?, output?);
    let (reference, picture) = (Picture::read(&args.reference)?, Picture::read(&args.picture)?);
    // Two sizes are a difference, but there is nothing to lay on one another.
    let found = match reference.size == picture.size {
        true => Ok(Difference::between(&reference, &picture)?),
        false => Err(sizes(&reference, &picture)),
    };
    let within = |most: Option<f64>, value: f64| most.is_none_or(|most| value <= most);
    let (right, said) = match &found {
        Err(said) => (false, said.clone()),
        Ok(found) if !found.any => (true, "they are the same".into()),
        Ok(found) => {
            let asked = args.flip.is_some() || args.error.is_some();
            let right = asked && within(args.flip, found.flip) && within(args.error, found.error);
            (right, format!("FLIP {:.4}, relative error² {:.3e}", found.flip, found.error))
        }
    };
    let found = found.ok();
    if let (Some(target), Some(found)) = (output, &found) {
        target.write(&found.png()?)?;
    }
    if let Some(target) = html {
        let shown = Shown {
            title: format!("{} and {}", args.reference.display(), args.picture.display()),
            right,
            word: if right { "right" } else { "changed" },
            said: said.clone(),
            reference: Some(reference.png()?),
            picture: Some(picture.png()?),
            difference: found.as_ref().map(Difference::png).transpose()?,
            ..Shown::default()
        };
        target.write(page("Two pictures", &said, &[shown]).as_bytes())?;
    }
    if args.json {
        let (flip, error) = found.as_ref().map(|found| (found.flip, found.error)).unzip();
        let numbers = Numbers { flip, error, same: found.is_some_and(|found| !found.any), said };
        terminal::out(&(serde_json::to_string(&numbers).unwrap_or_default() + "\n"))?;
    } else {
        terminal::out(&format!("{said}\n"))?;
    }
    Ok(if right { exit::CLEAN } else { exit::FINDINGS })
}

/// A number from 0.
fn limit(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| number.is_finite() && *number >= 0.0);
    number.ok_or_else(|| "write a number from 0".into())
}

/// A number from 0 to 1.
fn share(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number| (0.0..=1.0).contains(number));
    number.ok_or_else(|| "write a number from 0 to 1".into())
}
