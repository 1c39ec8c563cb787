//! The report as a self-contained HTML page: plots as SVG, pictures as data URLs.

use std::fs;
use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::BenchError;
use super::charts::Chart;
use super::report::{PictureEntry, PictureKind, Report};
use super::summary::Noise;
use super::tables::{Table, common_settings, milliseconds};
use crate::output::OutputError;

const STYLE: &str = include_str!("report.css");

/// Summary in one sentence.
pub(super) fn headline(report: &Report) -> String {
    let plan = &report.plan;
    format!(
        "{} on {}: {}, {} frames {}, {}.",
        "Real-time global illumination",
        report.machine.device,
        if report.scenes.len() == 1 {
            "1 scene".to_owned()
        } else {
            format!("{} scenes", report.scenes.len())
        },
        plan.frames,
        if plan.rounds == 1 { "once".to_owned() } else { format!("in each of {} rounds", plan.rounds) },
        common_settings(report),
    )
}

/// The whole page. `pictures` is the folder that holds them.
pub(super) fn page(
    report: &Report,
    tables: &[Table],
    charts: &[Chart],
    pictures: &Path,
) -> Result<String, BenchError> {
    let (detail, main): (Vec<&Table>, Vec<&Table>) = tables.iter().partition(|table| table.detail);
    let plots = charts.iter().map(figure).collect::<Result<Vec<_>, _>>()?;
    let markup = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { "glowworm bench: " (report.machine.device) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                header {
                    h1 { "glowworm bench" }
                    p { (headline(report)) }
                    dl {
                        @for (what, value) in report.machine.lines() {
                            dt { (what) } dd { (value) }
                        }
                    }
                }
                main {
                    section { h2 { "Scenes" } (scenes(report, pictures)?) }
                    section {
                        h2 { "Results" }
                        @if let Some(warning) = Noise::of(&report.runs).warning() { p.warning { (warning) } }
                        @for table in &main { (table_markup(table)) }
                    }
                    section { h2 { "Plots" } @for plot in &plots { (plot) } }
                    @if !report.equal_time.is_empty() {
                        section { h2 { "Equal time" } (equal_time(report, pictures)?) }
                    }
                    section { h2 { "Camera motion" } (artefacts(report, pictures)?) }
                    section {
                        h2 { "Details" }
                        @for table in &detail {
                            details { summary { (table.title) } (table_markup(table)) }
                        }
                        details { summary { "Settings and method" } (method(report)) }
                    }
                }
            }
        }
    };
    Ok(markup.into_string())
}

fn table_markup(table: &Table) -> Markup {
    html! {
        div.table {
            h3 { (table.title) }
            table {
                thead { tr { @for head in &table.columns { th { (head) } } } }
                tbody {
                    @for row in &table.rows {
                        tr {
                            @for (column, cell) in row.iter().enumerate() {
                                @if column == 0 { th scope="row" { (cell) } } @else { td { (cell) } }
                            }
                        }
                    }
                }
            }
            p.note { (table.note) }
        }
    }
}

fn figure(chart: &Chart) -> Result<Markup, BenchError> {
    let svg = chart.svg().map_err(|reason| OutputError::Encode("report.html".into(), reason))?;
    Ok(html! { figure.plot role="img" aria-label=(chart.title) { (PreEscaped(svg)) } })
}

fn scenes(report: &Report, pictures: &Path) -> Result<Markup, BenchError> {
    let mut cards = Vec::new();
    for scene in &report.scenes {
        let mut shown = Vec::new();
        for kind in [PictureKind::Beginning, PictureKind::End] {
            shown.extend(picture(report, &scene.name, kind, pictures)?);
        }
        cards.push(html! {
            div.card {
                h3 { (scene.name) }
                div.row { @for picture in shown { (picture) } }
                p.note {
                    (thousands(scene.triangles)) " triangles, "
                    (scene.instances) @if scene.instances == 1 { " instance, " } @else { " instances, " }
                    (scene.moving_instances) " of them dynamic, "
                    (scene.lights) @if scene.lights == 1 { " light" } @else { " lights" }
                }
            }
        });
    }
    Ok(html! { div.cards { @for card in cards { (card) } } })
}

/// For each scene the path tracer's picture, then each method's with its error, at equal time.
fn equal_time(report: &Report, pictures: &Path) -> Result<Markup, BenchError> {
    let mut rows = Vec::new();
    for scene in &report.scenes {
        let reference = picture(report, &scene.name, PictureKind::Reference, pictures)?;
        let mut cards = Vec::new();
        for equal in report.equal_time.iter().filter(|equal| equal.scene == scene.name) {
            let mut shown = Vec::new();
            for kind in [PictureKind::EqualTime, PictureKind::FlipMap] {
                let is_it = |entry: &&PictureEntry| {
                    entry.scene == scene.name
                        && entry.kind == kind
                        && entry.method.as_ref() == Some(&equal.run)
                };
                if let Some(entry) = report.pictures.iter().find(is_it) {
                    shown.push(picture_markup(entry, pictures)?);
                }
            }
            let (ms, flip) = (milliseconds(equal.ms), equal.error.flip);
            let text = format!("{}: {ms} ms, FLIP {flip:.4}", equal.run);
            cards.push(html! { div.card { h3 { (text) } div.row { @for picture in &shown { (picture) } } } });
        }
        rows.push(html! {
            div.card { h3 { (scene.name) } div.row { @if let Some(reference) = &reference { (reference) } } }
            @for card in &cards { (card) }
        });
    }
    Ok(html! {
        p {
            "Each method with so much of a setting, or so many samples a pixel, that a frame takes about as long as one of the first; in "
            "motion, at the last frame, with its FLIP error: black is 0, white 1."
        }
        div.wide { @for row in rows { (row) } }
    })
}

fn artefacts(report: &Report, pictures: &Path) -> Result<Markup, BenchError> {
    let mut rows = Vec::new();
    for scene in &report.scenes {
        let mut shown = Vec::new();
        for kind in PictureKind::ARTEFACTS {
            shown.extend(picture(report, &scene.name, kind, pictures)?);
        }
        rows.push(html! { div.card { h3 { (scene.name) } div.row { @for picture in shown { (picture) } } } });
    }
    let entry = report.pictures.iter().find(|entry| PictureKind::ARTEFACTS.contains(&entry.kind));
    let rendered_by = entry.map_or("", |entry| entry.rendered_by.as_str());
    Ok(html! {
        p {
            "The same view by " (rendered_by) " with a stationary camera, one that turns down at 30 degrees per second, "
            "and one that moves to the right by a picture's width in two seconds. Disocclusions have been seen in few "
            "frames, so they are noisier."
        }
        div.wide { @for row in rows { (row) } }
    })
}

fn picture(
    report: &Report,
    scene: &str,
    kind: PictureKind,
    folder: &Path,
) -> Result<Option<Markup>, BenchError> {
    let wanted = |entry: &&PictureEntry| entry.scene == scene && entry.kind == kind;
    report.pictures.iter().find(wanted).map(|entry| picture_markup(entry, folder)).transpose()
}

fn picture_markup(entry: &PictureEntry, folder: &Path) -> Result<Markup, BenchError> {
    let path = folder.join(&entry.file);
    let bytes = fs::read(&path).map_err(|source| OutputError::Read { path, source })?;
    let data = format!("data:image/png;base64,{}", STANDARD.encode(bytes));
    let caption = entry.kind.caption();
    let text = format!("{}, {caption}", entry.scene);
    Ok(html! {
        figure { img src=(data) alt=(text); figcaption { (caption) } }
    })
}

fn method(report: &Report) -> Markup {
    let plan = &report.plan;
    html! {
        ul {
            li {
                "A frame's time runs from its start until the device has finished it, and the next frame starts only then, so "
                "stages add up to it. In the window the CPU prepares a frame while the device draws the previous one, so "
                "the frame rate is higher. Nothing is presented, so no display limits it."
            }
            li {
                "Passes on the device are timed by timestamps, those on the CPU by its clock. Frame " code { "0" }
                " of the animation is the first measured one in every run; at least one warm-up frame per set "
                "precedes it."
            }
            li {
                "While camera, instances and lights are stationary, G-buffer and direct light are reused from frame to frame "
                "and cost nothing."
            }
            li {
                (plan.frames) " frames, " (plan.rounds) @if plan.rounds == 1 { " round" } @else { " rounds" }
                " of each setting; the rounds of all settings of a scene are interleaved."
            }
            li {
                "Confidence intervals come from the variance between rounds of one setting, pooled over all settings"
                @if plan.rounds == 1 {
                    ". With one round only, 5 % are assumed"
                }
                "."
            }
        }
        @for scene in &report.scenes {
            @if let Some(run) = report.runs_of(&scene.name).next() {
                p { b { (scene.name) } ": " code { (settings_text(&run.settings)) } }
            }
        }
    }
}

fn settings_text(settings: &crate::settings::Settings) -> String {
    serde_json::to_string(settings).unwrap_or_default()
}

/// 1234567 -> 1,234,567.
fn thousands(number: usize) -> String {
    let digits = number.to_string();
    let groups: Vec<&str> =
        digits.as_bytes().rchunks(3).rev().filter_map(|group| std::str::from_utf8(group).ok()).collect();
    groups.join(",")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thousands_are_grouped() {
        assert_eq!([0, 12, 123, 1234, 1_234_567].map(thousands), ["0", "12", "123", "1,234", "1,234,567"]);
    }
}
