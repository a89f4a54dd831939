//! A report as one HTML file, which needs nothing beside it: pictures are in it, and no network is asked.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::colors;

/// A comparison to show.
#[derive(Default)]
pub struct Shown {
    /// What was compared.
    pub title: String,
    /// Whether it is as it should be.
    pub right: bool,
    /// What came of it, in a word.
    pub word: &'static str,
    /// What came of it, in one line.
    pub said: String,
    /// What there is to say beyond that line, as plain text.
    pub more: String,
    /// What was asked for, as it is written.
    pub asked: String,
    /// The command that takes the picture as the reference.
    pub bless: Option<String>,
    /// The reference, as a PNG.
    pub reference: Option<Vec<u8>>,
    /// What it was compared with.
    pub picture: Option<Vec<u8>>,
    /// The difference, pixel by pixel.
    pub difference: Option<Vec<u8>>,
}

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

/// The page of these comparisons, what failed first.
pub fn page(title: &str, summary: &str, shown: &[Shown]) -> String {
    let mut order: Vec<&Shown> = shown.iter().collect();
    order.sort_by_key(|one| one.right);
    let cases: String = order.iter().map(|one| case(one)).collect();
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; \
         style-src 'unsafe-inline'; script-src 'unsafe-inline'\">\n\
         <link rel=\"icon\" href=\"data:,\">\n<title>{title}</title>\n\
         <style>\n{STYLE}.scale {{ background: linear-gradient(to right, {scale}); }}\n</style>\n</head>\n\
         <body>\n<h1>{title}</h1>\n<p>{summary}</p>\n<main>\n{cases}</main>\n\
         <script>\n{SCRIPT}</script>\n</body>\n</html>\n",
        title = escaped(title),
        summary = escaped(summary),
        scale = colors().join(", "),
    )
}

fn case(shown: &Shown) -> String {
    let Shown { title, right, word, said, more, asked, bless, .. } = shown;
    let (class, open) = if *right { ("right", "") } else { ("wrong", " open") };
    let mut text = format!(
        "<details class=\"{class}\"{open}>\n<summary><span class=\"word\">{word}</span> <b>{}</b> <span>{}</span>\
         </summary>\n",
        escaped(title),
        escaped(said)
    );
    if !asked.is_empty() {
        text += &format!("<p>asked for: <code>{}</code></p>\n", escaped(asked));
    }
    if !more.is_empty() {
        text += &format!("<pre>{}</pre>\n", escaped(more));
    }
    text += &figures(shown);
    if let Some(bless) = bless {
        let bless = escaped(bless);
        text += &format!("<p>if the picture is as it should be: <code>{bless}</code> takes it as the reference</p>\n");
    }
    text + "</details>\n"
}

/// The pictures beside each other; the script adds the other way to look at them.
fn figures(shown: &Shown) -> String {
    let Shown { title, said, reference, picture, difference, .. } = shown;
    let figure = |name: &str, png: &Option<Vec<u8>>, alt: String, below: &str| {
        png.as_ref().map(|png| {
            let (alt, data) = (escaped(&alt), STANDARD.encode(png));
            format!(
                "<figure class=\"{name}\"><img src=\"data:image/png;base64,{data}\" alt=\"{alt}\">\
                 <figcaption>{name}{below}</figcaption></figure>\n"
            )
        })
    };
    let legend = ": how much an eye sees (FLIP)<span class=\"legend\">0 <span class=\"scale\"></span> 1</span>";
    let figures = [
        figure("reference", reference, format!("the reference of {title}"), ""),
        figure("picture", picture, format!("the picture of {title} as it is now"), ""),
        figure("difference", difference, format!("where they differ: {said}"), legend),
    ];
    match figures.iter().flatten().count() {
        0 => String::new(),
        // Pictures of two sizes do not lie on one another.
        _ => format!(
            "<div class=\"pictures\"{}>\n{}</div>\n",
            if difference.is_some() { " data-swipe" } else { "" },
            figures.into_iter().flatten().collect::<String>()
        ),
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
