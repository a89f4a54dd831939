//! A report as one HTML file, which needs nothing beside it: pictures are in it, and no network is asked.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

/// A comparison to show.
pub struct Shown {
    /// What was compared.
    pub title: String,
    /// Whether it is as it should be.
    pub right: bool,
    /// What came of it, in one line.
    pub verdict: String,
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
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{title}</title>\n\
         <style>\n{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n<p>{summary}</p>\n{cases}\
         <script>\n{SCRIPT}</script>\n</body>\n</html>\n",
        title = escaped(title),
        summary = escaped(summary),
    )
}

fn case(shown: &Shown) -> String {
    let Shown { title, right, verdict, reference, picture, difference } = shown;
    let class = if *right { "right" } else { "wrong" };
    let mut body = String::new();
    if let (Some(reference), Some(picture)) = (reference, picture) {
        body += "<div class=\"views\"><button data-view=\"side\">side by side</button>\
                 <button data-view=\"swipe\">swipe</button></div>\n";
        let (a, b) = (source(reference), source(picture));
        body += &format!(
            "<div class=\"swipe\" hidden><div class=\"stack\"><img src=\"{a}\" alt=\"reference\">\
             <img class=\"over\" src=\"{b}\" alt=\"picture\"></div>\n\
             <input type=\"range\" min=\"0\" max=\"100\" value=\"50\" aria-label=\"reference left, picture right\"></div>\n"
        );
    }
    let figures = [("reference", reference), ("picture", picture), ("difference (FLIP)", difference)];
    let figure = |(name, png): (&str, &Option<Vec<u8>>)| {
        let png = png.as_ref()?;
        Some(format!("<figure><img src=\"{}\" alt=\"{name}\"><figcaption>{name}</figcaption></figure>\n", source(png)))
    };
    body += &format!("<div class=\"side\">\n{}</div>\n", figures.into_iter().filter_map(figure).collect::<String>());
    let open = if *right { "" } else { " open" };
    format!(
        "<details class=\"{class}\"{open}>\n<summary><b>{}</b> {}</summary>\n{body}</details>\n",
        escaped(title),
        escaped(verdict)
    )
}

fn source(png: &[u8]) -> String {
    format!("data:image/png;base64,{}", STANDARD.encode(png))
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
