//! `kinora diff`: how much two pictures differ.

use std::path::PathBuf;

use serde::Serialize;

use crate::encode::Target;
use crate::exit::{self, Outcome};
use crate::likeness::{Difference, Picture, Shown, page};
use crate::terminal;

/// Compare two pictures, by FLIP and by the relative error of their light.
///
/// Ends with 0 if they are as alike as asked for, and with 1 if they are not.
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
    flip: f64,
    error: f64,
    same: bool,
}

pub fn run(args: &Args) -> Outcome {
    let targets = [&args.html, &args.output].map(|path| path.as_deref().map(Target::new).transpose());
    let [html, output] = targets;
    let (html, output) = (html?, output?);
    let (reference, picture) = (Picture::read(&args.reference)?, Picture::read(&args.picture)?);
    let found = Difference::between(&reference, &picture)?;
    let right = match args.flip {
        Some(most) => found.flip <= most,
        None => !found.any,
    };
    let verdict = match found.any {
        true => format!("FLIP {:.4}, relative error² {:.3e}", found.flip, found.error),
        false => "they are the same".into(),
    };
    if let Some(target) = output {
        target.write(&found.png()?)?;
    }
    if let Some(target) = html {
        let shown = Shown {
            title: format!("{} and {}", args.reference.display(), args.picture.display()),
            right,
            verdict: verdict.clone(),
            reference: Some(reference.png()?),
            picture: Some(picture.png()?),
            difference: Some(found.png()?),
        };
        target.write(page("Two pictures", &verdict, &[shown]).as_bytes())?;
    }
    if args.json {
        let numbers = Numbers { flip: found.flip, error: found.error, same: !found.any };
        terminal::out(&(serde_json::to_string(&numbers).unwrap_or_default() + "\n"))?;
    } else {
        terminal::out(&format!("{verdict}\n"))?;
    }
    Ok(if right { exit::CLEAN } else { exit::FINDINGS })
}

/// A number from 0 to 1.
pub fn share(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number| (0.0..=1.0).contains(number));
    number.ok_or_else(|| "write a number from 0 to 1".into())
}
