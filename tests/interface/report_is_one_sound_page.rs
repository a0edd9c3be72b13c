//! The report of `goldtof run`: one page, its numbers those of the JSON, its diagram
//! that of the emission, sound in a browser.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

use crate::program::{QUICK, command};

/// Runs a scene with both estimators; its JSON and its page.
fn run(scene: &str, out: &Path, epoch: Option<&str>) -> (Value, String) {
    let mut command = command(&[]);
    command.args(["run", scene, "--estimator", "model", "--json", "--quiet", "--out"]).arg(out);
    match epoch {
        Some(epoch) => command.env("SOURCE_DATE_EPOCH", epoch),
        None => command.env_remove("SOURCE_DATE_EPOCH"),
    };
    let output = command.output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    (serde_json::from_slice(&output.stdout).unwrap(), page)
}

/// Every value of an attribute.
fn attributes<'p>(page: &'p str, name: &str) -> Vec<&'p str> {
    let begin = format!(" {name}=\"");
    let values = page.split(begin.as_str()).skip(1);
    values.map(|rest| rest.split('"').next().unwrap()).collect()
}

#[test]
fn its_numbers_are_those_of_the_json() {
    let out = tempfile::tempdir().unwrap();
    let (json, page) = run(QUICK, out.path(), None);
    let millimetres = |value: &Value| value.as_f64().unwrap() * 1e3;
    for estimate in [&json["estimates"][0], &json["other_estimates"][0]] {
        let distance = format!("{:.4} m", estimate["distance_m"].as_f64().unwrap());
        let error = format!("{:+.2} mm", millimetres(&estimate["error_m"]));
        let std = format!("+- {:.2} mm", millimetres(&estimate["expected_std_m"]));
        for words in [distance, error, std] {
            assert!(page.contains(&words), "{words}");
        }
    }
    assert_eq!(json["cosim"]["clocks"], 620_012);
    assert!(page.contains("620,012") && page.contains("4.96 ms"));
    for part in json["plan"]["hardware"].as_array().unwrap() {
        let name = part["part"].as_str().unwrap().replace('_', " ");
        assert!(page.contains(&name), "{name}");
    }
    for port in json["emit"]["ports"].as_array().unwrap() {
        assert!(page.contains(port["name"].as_str().unwrap()), "{port}");
    }
}

#[test]
fn its_diagram_has_the_modules_of_the_emission() {
    // The second one's have parameters.
    for scene in [QUICK, "scenes/histogram.toml"] {
        let out = tempfile::tempdir().unwrap();
        let (json, page) = run(scene, out.path(), None);
        // Every text between tags.
        let texts = page.split('>').filter_map(|text| text.split('<').next());
        let drawn: BTreeSet<&str> = texts.map(str::trim).collect();
        for file in json["emit"]["files"].as_array().unwrap() {
            let file = file.as_str().unwrap();
            let text = fs::read_to_string(out.path().join("rtl").join(file)).unwrap();
            let module = file.strip_suffix(".v").unwrap();
            // Whole modules that only simulators read are not hardware.
            let first = text.find("module ").unwrap();
            let is_hardware = !text[..first].contains("`ifndef SYNTHESIS");
            // Several of a kind are one block with their number.
            let several = format!(" \u{d7} {module}");
            let is_drawn = drawn.iter().any(|text| *text == module || text.ends_with(&several));
            assert_eq!(is_drawn, is_hardware, "{module}: {drawn:?}");
        }
        assert!(!drawn.contains("#"), "{drawn:?}");
    }
}

#[test]
fn names_are_escaped_in_text_and_drawings() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("odd.toml");
    let text = fs::read_to_string(QUICK).unwrap();
    let text = text.replace("\"laser\"", "\"l<i>&'x\"").replace("\"spad\"", "\"</svg><b>\"");
    fs::write(&scene, text).unwrap();
    let (_, page) = run(scene.to_str().unwrap(), &folder.path().join("out"), None);
    assert!(!page.contains("<i>") && !page.contains("<b>"));
    assert!(page.contains("l&lt;i&gt;&amp;'x") && page.contains("&lt;/svg&gt;&lt;b&gt;"));
    assert_eq!(page.matches("<svg").count(), page.matches("</svg>").count());
}

#[test]
fn it_stands_alone_and_every_drawing_has_words() {
    let out = tempfile::tempdir().unwrap();
    let (_, page) = run(QUICK, out.path(), None);
    for outside in
        ["<script", "<link", "<img", "<iframe", "http:", "https:", " src=", "@import", "url("]
    {
        // Arrows of a drawing are named by their drawing.
        assert!(!page.replace("url(#", "").contains(outside), "{outside}");
    }
    let ids = attributes(&page, "id");
    let links = attributes(&page, "href");
    assert!(links.len() >= 2, "{links:?}");
    for link in links {
        let leads_to = link.strip_prefix('#').expect("no link leads out of the page");
        assert!(ids.contains(&leads_to), "{link}");
    }
    assert_eq!(ids.iter().collect::<BTreeSet<_>>().len(), ids.len(), "{ids:?}");
    let labelled = attributes(&page, "aria-labelledby");
    assert_eq!(labelled.len(), page.matches("<svg").count());
    assert!(labelled.len() >= 8, "{labelled:?}");
    for id in labelled.iter().flat_map(|both| both.split(' ')) {
        let words = page.split(&format!(" id=\"{id}\">")).nth(1).unwrap();
        assert!(!words.starts_with('<'), "{id} is empty");
    }
    assert!(!page.contains("NaN") && !page.contains("inf,"));
}

#[test]
fn with_a_date_that_is_given_it_is_the_same_byte_for_byte() {
    let out = tempfile::tempdir().unwrap();
    let epoch = Some("1767225600");
    let (_, first) = run(QUICK, out.path(), epoch);
    let (_, second) = run(QUICK, out.path(), epoch);
    assert!(first == second);
    assert!(first.contains("2026-01-01T00:00:00Z"));
    let output = command(&["run", QUICK, "--out"])
        .arg(out.path())
        .env("SOURCE_DATE_EPOCH", "yesterday")
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(told.contains("SOURCE_DATE_EPOCH is \"yesterday\""), "{told}");
}

/// A page that holds another of some width, and says how wide that really is and what
/// it asked for.
fn measuring(page: &str, width: u32) -> String {
    let quoted = page.replace('&', "&amp;").replace('"', "&quot;");
    format!(
        "<!DOCTYPE html><iframe id=f width={width} height=800 style='border:0' srcdoc=\"{quoted}\"></iframe>\
         <pre id=r></pre><script>f.onload = () => {{ const d = f.contentDocument.documentElement; \
         r.textContent = 'measured ' + d.clientWidth + ' ' + d.scrollWidth + ' ' + \
         f.contentWindow.performance.getEntriesByType('resource').length + ' end'; }};</script>"
    )
}

#[test]
fn a_browser_finds_no_fault_and_nothing_to_scroll_sideways() {
    let Some(chromium) =
        ["chromium", "chromium-browser", "google-chrome"].into_iter().find(|name| {
            Command::new(name).arg("--version").output().is_ok_and(|o| o.status.success())
        })
    else {
        eprintln!("SKIPPED: no Chromium on this machine (Debian's package chromium)");
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let (_, page) = run(QUICK, &folder.path().join("out"), None);
    for width in [400, 1100] {
        let file = folder.path().join("measure.html");
        fs::write(&file, measuring(&page, width)).unwrap();
        let output = Command::new(chromium)
            .args([
                "--headless",
                "--no-sandbox",
                "--disable-gpu",
                "--disable-background-networking",
            ])
            .args(["--enable-logging=stderr", "--virtual-time-budget=5000", "--dump-dom"])
            .arg(format!("--user-data-dir={}", folder.path().join("profile").display()))
            .arg(format!("file://{}", file.display()))
            .output()
            .unwrap();
        let dom = String::from_utf8_lossy(&output.stdout);
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(!said.contains(":CONSOLE"), "{said}");
        let measured = dom.rsplit("<pre id=\"r\">measured ").next().unwrap();
        let numbers: Vec<u32> = measured
            .split(" end")
            .next()
            .unwrap()
            .split(' ')
            .map(|number| number.parse().unwrap_or_else(|_| panic!("{said}")))
            .collect();
        let [client, scroll, requests] = numbers[..] else { panic!("{numbers:?}") };
        assert!(client > 0 && client <= width, "{numbers:?}");
        assert!(scroll <= client, "{width} px: {numbers:?}");
        assert_eq!(requests, 0);
    }
}
