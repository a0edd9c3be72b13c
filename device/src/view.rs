//! What `watch` shows: each detector's distance, the counts of the newest scan, the distances of the last ones, the
//! line. Nothing here waits or reads, so that a test can draw it.

use std::collections::VecDeque;
use std::fmt::Write as _;

use goldtof::Sensor;
use goldtof::estimate::distance_m;
use goldtof::estimate::report::EstimateReport;
use goldtof_device::{DetectorScan, Largest, Report, Scan, hexadecimal};
use goldtof_wire::{Content, Identity};
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style};
use ratatui::symbols::Marker;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Axis, Block, Chart, Dataset, GraphType, Paragraph};

/// Distances that are kept for their mean and scatter.
const KEPT: usize = 200;
/// Phase steps on either side of the peak that zooming leaves, in chips.
const ZOOM_CHIPS: u64 = 3;
/// Colours of the detectors.
const COLOURS: [Color; 4] = [Color::Cyan, Color::Yellow, Color::Magenta, Color::Green];

/// What the estimator makes of a scan, detector by detector; or why it is none of the scene.
#[derive(Debug)]
pub(crate) struct Answers {
    /// The scan's number.
    pub scan: u64,
    /// What each detector's counts say.
    pub of: Vec<Result<EstimateReport, String>>,
}

/// How it stands with the line.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum State {
    /// Something comes.
    Listening,
    /// Nothing comes.
    Silent,
    /// The device is gone, and is waited for.
    Gone(String),
}

/// A detector's last distances.
#[derive(Debug, Default)]
struct History {
    /// Number of the scan, and the distance in metres.
    distances: VecDeque<(u64, f64)>,
}

/// All that is shown.
#[derive(Debug)]
pub(crate) struct View {
    port: String,
    baud: u32,
    identity: Identity,
    scene: Option<String>,
    detectors: Vec<String>,
    state: State,
    report: Option<Report>,
    written: Option<(u64, String)>,
    scan: Option<Scan>,
    answers: Option<Answers>,
    histories: Vec<History>,
    is_zoomed: bool,
}

/// A length with as many digits as are worth reading.
fn millimetres(metres: f64) -> String {
    let millimetres = metres * 1e3;
    match millimetres.abs() {
        large if large >= 9.95 => format!("{millimetres:.0} mm"),
        small if small >= 0.095 => format!("{millimetres:.1} mm"),
        _ => format!("{millimetres:.3} mm"),
    }
}

/// The standard deviation that goes with an estimate: the fit's own, or the expected one.
fn std_m(report: &EstimateReport) -> Option<f64> {
    let fit = report.fit.as_ref().and_then(|fit| {
        let own = fit.paths.iter().find(|path| Some(path.distance_m) == report.distance_m)?;
        Some(own.distance_std_m)
    });
    fit.or(report.expected_std_m)
}

impl History {
    /// Mean and standard deviation; a code's period is a circle of `range_m`.
    fn mean_and_std(&self, range_m: f64) -> Option<(f64, f64)> {
        let n = self.distances.len() as f64;
        let (_, first) = *self.distances.front()?;
        if self.distances.len() < 2 {
            return None;
        }
        let from_first = |distance: f64| {
            let difference = distance - first;
            difference - (difference / range_m).round() * range_m
        };
        let mean = self.distances.iter().map(|&(_, d)| from_first(d)).sum::<f64>() / n;
        let squares = self.distances.iter().map(|&(_, d)| (from_first(d) - mean).powi(2));
        Some(((first + mean).rem_euclid(range_m), (squares.sum::<f64>() / (n - 1.0)).sqrt()))
    }
}

impl View {
    /// Before anything has come; `sensor` is what the device was built from, if that is known.
    pub fn new(port: &str, baud: u32, identity: Identity, sensor: Option<&Sensor>) -> View {
        let detectors: Vec<String> = match sensor {
            Some(sensor) => sensor.scene().detectors.iter().map(|d| d.name.clone()).collect(),
            None => (0..identity.detectors).map(|number| format!("detector {number}")).collect(),
        };
        View {
            port: port.to_owned(),
            baud,
            identity,
            scene: sensor.map(|sensor| sensor.scene().name.clone()),
            histories: detectors.iter().map(|_| History::default()).collect(),
            detectors,
            state: State::Listening,
            report: None,
            written: None,
            scan: None,
            answers: None,
            is_zoomed: false,
        }
    }

    pub fn identity(&self) -> Identity {
        self.identity
    }

    pub fn is_gone(&self) -> bool {
        matches!(self.state, State::Gone(_))
    }

    pub fn set_state(&mut self, state: State) {
        self.state = state;
    }

    pub fn set_scan(&mut self, scan: Scan) {
        self.scan = Some(scan);
    }

    pub fn set_report(&mut self, report: Report, written: Option<(u64, String)>) {
        self.report = Some(report);
        self.written = written;
    }

    /// Takes what the estimator says of a scan.
    pub fn set_answers(&mut self, answers: Answers) {
        for (history, answer) in self.histories.iter_mut().zip(&answers.of) {
            let Some(distance_m) = answer.as_ref().ok().and_then(|report| report.distance_m) else {
                continue;
            };
            if history.distances.len() == KEPT {
                history.distances.pop_front();
            }
            history.distances.push_back((answers.scan, distance_m));
        }
        self.answers = Some(answers);
    }

    /// Forgets the last distances.
    pub fn clear(&mut self) {
        self.histories.iter_mut().for_each(|history| history.distances.clear());
    }

    /// Shows the counts round the peak, or all of them again.
    pub fn zoom(&mut self) {
        self.is_zoomed = !self.is_zoomed;
    }

    /// Draws all of it.
    pub fn draw(&self, frame: &mut Frame) {
        let lines = 2 * self.detectors.len() as u16 + 2;
        let areas = Layout::vertical([
            Constraint::Length(lines.min(frame.area().height / 2)),
            Constraint::Fill(3),
            Constraint::Length(11),
        ]);
        let [top, middle, bottom] = areas.areas(frame.area());
        let [left, right] =
            Layout::horizontal([Constraint::Fill(1), Constraint::Length(46)]).areas(bottom);
        self.draw_distances(frame, top);
        self.draw_counts(frame, middle);
        self.draw_history(frame, left);
        self.draw_line(frame, right);
    }

    fn draw_distances(&self, frame: &mut Frame, area: Rect) {
        let scene = self.scene.as_deref().unwrap_or("scene unknown, distances are coarse");
        let hash = hexadecimal(&self.identity.scene);
        let title = format!(" {} | {scene} | {hash} ", self.port);
        let state = match &self.state {
            State::Listening => Span::from(" listening ").style(Color::Green),
            State::Silent => Span::from(" silent: nothing comes ").style(Color::Yellow),
            State::Gone(_) => Span::from(" gone: waiting for it ").style(Color::Red),
        };
        let lines: Vec<Line> = (0..self.detectors.len()).flat_map(|k| self.distance(k)).collect();
        let block = Block::bordered().title(title).title(Line::from(state).right_aligned());
        frame.render_widget(Paragraph::new(lines).block(block), area);
    }

    /// A detector's distance and its peak; below it the mean of the last ones, or what is wrong.
    fn distance(&self, detector: usize) -> [Line<'_>; 2] {
        let bold = Style::from(colour(detector)).add_modifier(Modifier::BOLD);
        let name = Span::from(format!("{:<12} ", self.detectors[detector])).style(bold);
        let peak =
            self.scan.as_ref().and_then(|scan| peak(scan.detectors.get(detector)?, &self.identity));
        let at_peak =
            peak.map_or(String::new(), |(step, count)| format!("   peak {count} at step {step}"));
        let answer = self.answers.as_ref().and_then(|answers| answers.of.get(detector));
        let (told, more) = match (answer, peak, &self.scene) {
            (Some(Ok(report)), ..) => self.estimate(detector, report),
            (Some(Err(wrong)), ..) => (String::new(), format!("no counts of this scene: {wrong}")),
            // Anywhere within the step: its standard deviation is that of a uniform number.
            (None, Some((step, _)), None) => {
                let [metres, std_m] =
                    [step as f64, 1.0 / 12_f64.sqrt()].map(|steps| self.identity.distance_m(steps));
                (
                    format!("{metres:.3} m +- {}", millimetres(std_m)),
                    "--scene gives the estimator's".into(),
                )
            }
            (None, Some(_), Some(_)) => ("...".to_owned(), String::new()),
            (None, None, _) if self.scan.is_none() => {
                ("no whole scan yet".to_owned(), String::new())
            }
            (None, None, _) => ("no peak".to_owned(), "no count stands out".to_owned()),
        };
        let first = vec![name, Span::from(told).style(bold), Span::from(at_peak)];
        let more = Span::from(format!("{:13}{more}", "")).style(Color::Gray);
        [Line::from(first), Line::from(more)]
    }

    /// What the estimator says; and its mean, or what it remarks.
    fn estimate(&self, detector: usize, report: &EstimateReport) -> (String, String) {
        let Some(metres) = report.distance_m else {
            return ("no distance".to_owned(), report.remark.clone().unwrap_or_default());
        };
        let std_m = std_m(report).map(|std_m| format!(" +- {}", millimetres(std_m)));
        let told = format!("{metres:.3} m{}", std_m.unwrap_or_default());
        let mut more = String::new();
        let history = &self.histories[detector];
        let statistics = history.mean_and_std(report.unambiguous_range_m);
        if let Some((mean_m, std_m)) = statistics {
            let n = history.distances.len();
            let std_of_mean = millimetres(std_m / (n as f64).sqrt());
            let _ = write!(more, "mean of {n} scans {mean_m:.4} m +- {std_of_mean}");
            let _ = write!(more, ", scatter {}", millimetres(std_m));
        }
        if let Some(bias_m) = report.expected_bias_m.filter(|bias_m| bias_m.abs() >= 5e-5) {
            let comma = if more.is_empty() { "" } else { "; " };
            let _ = write!(more, "{comma}bias expected of the scene {}", millimetres(bias_m));
        }
        // That a target is not where the scene has it is no news here.
        let remark = report.remark.as_deref().and_then(|remark| remark.split("; ").next());
        if let Some(remark) = remark.filter(|remark| remark.starts_with("coarse")) {
            let comma = if more.is_empty() { "" } else { "; " };
            let _ = write!(more, "{comma}{remark}");
        }
        (told, more)
    }

    /// Counts over distance, and where the estimates are.
    fn draw_counts(&self, frame: &mut Frame, area: Rect) {
        let block = |title: String| Block::bordered().title(title);
        let Some(scan) = &self.scan else {
            frame.render_widget(block(" counts ".to_owned()), area);
            return;
        };
        let curves: Vec<Vec<(f64, f64)>> = scan
            .detectors
            .iter()
            .enumerate()
            .map(|(k, of)| self.curve(k, of, area.width))
            .collect();
        let all = || curves.iter().flatten();
        let (low, high) = bounds(all().map(|point| point.1).chain([0.0]));
        let (from, to) = bounds(all().map(|point| point.0));
        let marks: Vec<Vec<(f64, f64)>> = (0..curves.len())
            .map(|k| match self.answer(k).and_then(|report| report.distance_m) {
                Some(metres) if (from..to).contains(&metres) => vec![(metres, low), (metres, high)],
                _ => Vec::new(),
            })
            .collect();
        let line = |points, style: Style| {
            let dataset = Dataset::default().marker(Marker::Braille).graph_type(GraphType::Line);
            dataset.data(points).style(style)
        };
        // What is drawn first is on top.
        let curves = curves.iter().enumerate().map(|(k, curve)| line(curve, colour(k).into()));
        let marks = marks.iter().map(|mark| line(mark, Color::White.into()));
        let counts = match self.identity.content {
            Content::Rows => "bins",
            Content::Counts | Content::Peaks => "counts",
        };
        let title = format!(" {counts} of scan {} over distance in m ", scan.number);
        let chart = Chart::new(curves.chain(marks).collect())
            .block(block(title).title_bottom(" q quit  z zoom  c clear "))
            .x_axis(axis(from, to, 2))
            .y_axis(axis(low, high, 0));
        frame.render_widget(chart, area);
    }

    fn answer(&self, detector: usize) -> Option<&EstimateReport> {
        self.answers.as_ref()?.of.get(detector)?.as_ref().ok()
    }

    /// A detector's counts over distance in as many places as a terminal so wide has dots.
    fn curve(&self, detector: usize, of: &DetectorScan, columns: u16) -> Vec<(f64, f64)> {
        let offset_m = self.answer(detector).map_or(0.0, |r| distance_m(r.calibration_offset_ps));
        let steps_of_period =
            u64::from(self.identity.samples_per_chip) * u64::from(self.identity.code_chips);
        let (first, peak) =
            (of.phase_steps.first().copied().unwrap_or(0), peak(of, &self.identity));
        let near = u64::from(self.identity.samples_per_chip) * ZOOM_CHIPS;
        let points = of.phase_steps.iter().zip(&of.counts).filter_map(|(&step, &count)| {
            // A scan that goes on at the period's beginning is drawn in one piece.
            let step = if step < first { step + steps_of_period } else { step };
            let is_shown = !self.is_zoomed
                || peak.is_none_or(|(at, _)| {
                    let at = if at < first { at + steps_of_period } else { at };
                    step.abs_diff(at) <= near
                });
            is_shown.then(|| (self.identity.distance_m(step as f64) - offset_m, count as f64))
        });
        let points: Vec<(f64, f64)> = points.collect();
        envelope(&points, 2 * usize::from(columns).max(1))
    }

    fn draw_history(&self, frame: &mut Frame, area: Rect) {
        let curves: Vec<Vec<(f64, f64)>> = self
            .histories
            .iter()
            .map(|history| history.distances.iter().map(|&(scan, m)| (scan as f64, m)).collect())
            .collect();
        let all = || curves.iter().flatten();
        let block = Block::bordered().title(" last distances in m ");
        if all().next().is_none() {
            frame.render_widget(block, area);
            return;
        }
        let (low, high) = bounds(all().map(|point| point.1));
        let (from, to) = bounds(all().map(|point| point.0));
        let to = to.max(from + 1.0);
        let dots = curves.iter().enumerate().map(|(k, curve)| {
            let dataset = Dataset::default().marker(Marker::Dot).graph_type(GraphType::Scatter);
            dataset.data(curve).style(colour(k))
        });
        let chart = Chart::new(dots.collect())
            .block(block)
            .x_axis(
                Axis::default()
                    .bounds([from, to])
                    .labels([format!("scan {from:.0}"), format!("{to:.0}")]),
            )
            .y_axis(axis(low, high, 3));
        frame.render_widget(chart, area);
    }

    fn draw_line(&self, frame: &mut Frame, area: Rect) {
        let mut lines = Vec::new();
        let mut say = |name: &str, told: String, style: Style| {
            let told = Span::from(told).style(style);
            lines.push(Line::from(vec![Span::from(format!("{name:<8}")).style(Color::Gray), told]));
        };
        let plain = Style::default();
        let bad = |is_bad: bool| if is_bad { Style::from(Color::Red) } else { plain };
        if let Some(report) = &self.report {
            let tally = &report.tally;
            let scans_per_s = report.results_per_s / self.identity.results_of_scan() as f64;
            let rate = format!("{:.0} results/s, {scans_per_s:.2} scans/s", report.results_per_s);
            say("rate", rate, plain);
            let share = report.bytes_per_s * 10.0 / f64::from(self.baud) * 1e2;
            let bytes = format!("{:.1} kB/s, {share:.0} % of the line", report.bytes_per_s * 1e-3);
            say("line", bytes, plain);
            say(
                "scans",
                format!("{} in {:.0} s", report.scans, report.elapsed.as_secs_f64()),
                plain,
            );
            let mut lost = format!("{} frames, {} results", tally.lost_frames, tally.lost_results);
            if tally.uncertain > 0 {
                let _ = write!(lost, ", {} x unknown", tally.uncertain);
            }
            say("lost", lost, bad(tally.lost_frames > 0));
            let in_bridge = format!("{} in the bridge", tally.dropped);
            say("dropped", in_bridge, bad(tally.dropped > 0));
            say("torn", format!("{}, doubled {}", tally.torn, tally.doubled), bad(tally.torn > 0));
            let flags = [(report.overrun, "OVERRUN"), (report.saturated, "SATURATED")];
            let flags = flags.iter().filter(|(is_set, _)| *is_set).map(|(_, name)| *name);
            let flags = flags.collect::<Vec<_>>().join(" ");
            let is_set = !flags.is_empty();
            say("flags", if is_set { flags } else { "none".to_owned() }, bad(is_set));
        }
        if let Some((results, path)) = &self.written {
            say("file", format!("{results} results in {path}"), plain);
        }
        if let State::Gone(why) = &self.state {
            say("gone", why.clone(), bad(true));
        }
        let block = Block::bordered().title(" line ");
        frame.render_widget(Paragraph::new(lines).block(block), area);
    }
}

fn colour(detector: usize) -> Color {
    COLOURS[detector % COLOURS.len()]
}

/// Phase step and count of the largest count.
fn peak(of: &DetectorScan, identity: &Identity) -> Option<(u64, i64)> {
    let mut largest = Largest::default();
    of.phase_steps.iter().zip(&of.counts).for_each(|(&step, &count)| largest.take(step, count));
    largest.peak(2 * usize::from(identity.samples_per_chip))
}

/// The least and the greatest of some numbers, which are not the same.
fn bounds(numbers: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) =
        numbers.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
    match high - low {
        span if span > 1e-6 => (low, high),
        _ if low.is_finite() => (low, high + 1e-3),
        _ => (0.0, 1.0),
    }
}

fn axis<'a>(low: f64, high: f64, digits: usize) -> Axis<'a> {
    let labels = [low, f64::midpoint(low, high), high].map(|at| format!("{at:.digits$}"));
    Axis::default().bounds([low, high]).labels(labels).style(Color::Gray)
}

/// The least and the greatest value of each column, so that no peak is lost between dots.
fn envelope(points: &[(f64, f64)], columns: usize) -> Vec<(f64, f64)> {
    if points.len() <= 2 * columns {
        return points.to_vec();
    }
    let ends = |piece: &[(f64, f64)]| {
        let order = |a: &&(f64, f64), b: &&(f64, f64)| a.1.total_cmp(&b.1);
        let ends = [piece.iter().min_by(order), piece.iter().max_by(order)];
        let mut ends: Vec<(f64, f64)> = ends.into_iter().flatten().copied().collect();
        ends.sort_by(|a, b| a.0.total_cmp(&b.0));
        ends
    };
    points.chunks(points.len().div_ceil(columns)).flat_map(ends).collect()
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use goldtof::scene::DetectorIndex;
    use goldtof_wire::{Layout as Bits, Tally};
    use ratatui::Terminal;
    use ratatui::backend::TestBackend;

    use super::*;

    fn quick() -> Identity {
        Identity {
            content: Content::Counts,
            layout: Bits { count_bits: 17, counts: 1, more_bits: 0 },
            detectors: 1,
            samples_per_chip: 8,
            chip_period_fs: 8_000_000,
            first_step: 0,
            steps: 248,
            code_chips: 31,
            parallel: 1,
            accumulate: 1,
            text_blocks: 0,
            counts_samples: false,
            scene: [1, 2, 3, 4, 5, 6, 7, 8],
        }
    }

    /// A scan with a triangle of a chip on either side of a step.
    fn scan(number: u64, peak: u64) -> Scan {
        let counts =
            (0..248).map(|step: u64| 30 * 8_u64.saturating_sub(step.abs_diff(peak)) as i64);
        let of = DetectorScan {
            phase_steps: (0..248).collect(),
            counts: counts.collect(),
            totals: Vec::new(),
        };
        Scan { number, time_s: 0.0, detectors: vec![of] }
    }

    fn drawn(view: &View, columns: u16, rows: u16) -> String {
        let mut terminal = Terminal::new(TestBackend::new(columns, rows)).unwrap();
        terminal.draw(|frame| view.draw(frame)).unwrap();
        let cells = terminal.backend().buffer().content();
        let lines = cells.chunks(usize::from(columns));
        lines.map(|line| line.iter().map(|cell| cell.symbol()).collect::<String>() + "\n").collect()
    }

    #[test]
    fn without_a_scene_the_distance_is_the_largest_counts() {
        let mut view = View::new("/dev/ttyUSB1", 3_000_000, quick(), None);
        let text = drawn(&view, 100, 30);
        assert!(text.contains("no whole scan yet") && text.contains("scene unknown"), "{text}");
        view.set_scan(scan(4, 21));
        let text = drawn(&view, 100, 30);
        // A step of a nanosecond is 149.9 mm, and a number anywhere within it scatters by a root of 12 of that.
        assert!(text.contains("3.148 m +- 43 mm   peak 240 at step 21"), "{text}");
        assert!(text.contains(" counts of scan 4 over distance in m "), "{text}");
        // 248 steps are 37.2 m; three chips on either side of the peak are 24 steps.
        assert!(text.contains("37.02"), "{text}");
        view.zoom();
        let text = drawn(&view, 100, 30);
        assert!(text.contains("6.75") && !text.contains("37.02"), "{text}");
    }

    fn answers(number: u64, distance_m: f64) -> Answers {
        let sensor = Sensor::load("../scenes/quick.toml").unwrap();
        let empty = goldtof::estimate::report::Reporter::new(&sensor, DetectorIndex(0)).expected();
        Answers {
            scan: number,
            of: vec![Ok(EstimateReport { distance_m: Some(distance_m), ..empty })],
        }
    }

    #[test]
    fn means_and_scatter_are_those_of_the_last_scans_round_the_period() {
        let sensor = Sensor::load("../scenes/quick.toml").unwrap();
        let mut view = View::new("p", 3_000_000, quick(), Some(&sensor));
        view.set_scan(scan(0, 0));
        // The range of 31 chips of 8 ns is 37.174 m: these lie round 0.
        for (number, distance_m) in (0..).zip([0.010, 37.164, 0.020, 37.154]) {
            view.set_answers(answers(number, distance_m));
        }
        let text = drawn(&view, 120, 30);
        // -20, -10, 10 and 20 mm: a standard deviation of the root of 1000 / 3.
        assert!(text.contains("scatter 18 mm"), "{text}");
        let (mean, error) = (text.contains(" 0.0000 m +- 9.1 mm"), text.contains(" 37.17"));
        assert!(text.contains("mean of 4 scans") && (mean || error), "{text}");
        view.clear();
        assert!(!drawn(&view, 120, 30).contains("mean of"));
    }

    #[test]
    fn losses_flags_and_a_device_that_is_gone_are_told() {
        let mut view = View::new("p", 3_000_000, quick(), None);
        let tally =
            Tally { lost_frames: 3, lost_results: 186, torn: 2, dropped: 7, ..Tally::default() };
        let report = Report {
            elapsed: Duration::from_secs(12),
            scans: 40,
            results_per_s: 496.0,
            bytes_per_s: 150_000.0,
            peak: None,
            overrun: true,
            saturated: false,
            tally,
        };
        view.set_report(report, Some((9920, "counts.csv".to_owned())));
        view.set_state(State::Gone("the device is gone".to_owned()));
        let text = drawn(&view, 100, 30);
        for told in [
            "gone: waiting for it",
            "496 results/s, 2.00 scans/s",
            // 150 kB of ten bits each.
            "150.0 kB/s, 50 % of the line",
            "40 in 12 s",
            "3 frames, 186 results",
            "7 in the bridge",
            "2, doubled 0",
            "OVERRUN",
            "9920 results in counts.csv",
        ] {
            assert!(text.contains(told), "{told} is not in\n{text}");
        }
        // A small terminal has less, and no panic.
        (1..40).for_each(|size| drop(drawn(&view, 3 * size, size)));
    }
}
