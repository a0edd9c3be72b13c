//! Listening to a device for as long as the user wants: in lines, or in a view.

use std::fs::{self, File, OpenOptions};
use std::io::{self, IsTerminal as _};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, channel, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

use goldtof::Sensor;
use goldtof_device::{
    Feed, Line, News, Ranging, RecordError, Recorder, Reopen, Report, Scan, Scans, Watch, What,
};
use goldtof_system::printable::printable_path;
use goldtof_wire::{Event, Frame, Identity, Tally};
use ratatui::DefaultTerminal;
use ratatui::crossterm::event::{self, Event as Terminal, KeyCode, KeyEvent, KeyModifiers};
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};

use crate::parts::Parts;
use crate::view::{Answers, State, View};
use crate::{Failed, Recording, description};

/// How long to wait for news before the clock and the keys are looked at.
const AT_ONCE: Duration = Duration::from_millis(20);
/// How often the view is drawn, and how often its rates are new.
const DRAWN: Duration = Duration::from_millis(100);
const REPORTED: Duration = Duration::from_secs(1);
/// A line that has told nothing for as long is said to be silent.
const SILENT: Duration = Duration::from_secs(2);

/// What becomes of what a device sends, whoever shows it.
struct Session {
    watch: Watch,
    tally: Tally,
    out: Option<(Out, PathBuf)>,
    ends: Option<Instant>,
    stopped: Arc<AtomicBool>,
}

impl Session {
    fn new(identity: Identity, recording: &Recording) -> Result<Session, Failed> {
        let out = recording.out.as_deref().map(|path| {
            let losses = path.with_added_extension("losses.csv");
            let out = match path.extension() {
                Some(ending) if ending == "parquet" => {
                    Out::Parquet(Parts::new(path, fresh(&losses)?, identity)?)
                }
                _ => Out::Csv(Recorder::new(fresh(path)?, fresh(&losses)?, identity)?),
            };
            Ok::<(Out, PathBuf), Failed>((out, path.to_owned()))
        });
        // The first signal ends the job, the next one the program.
        let stopped = Arc::new(AtomicBool::new(false));
        for signal in [SIGINT, SIGTERM, SIGHUP] {
            let again = Arc::clone(&stopped);
            signal_hook::flag::register_conditional_shutdown(signal, 128 + signal, again)?;
            signal_hook::flag::register(signal, Arc::clone(&stopped))?;
        }
        let ends = recording.seconds.map(|seconds| {
            let seconds = Duration::try_from_secs_f64(seconds);
            seconds.map(|seconds| Instant::now() + seconds)
        });
        Ok(Session {
            watch: Watch::new(identity),
            tally: Tally::default(),
            out: out.transpose()?,
            ends: ends.transpose().map_err(|error| format!("--seconds: {error}"))?,
            stopped,
        })
    }

    /// Whether the user wants no more.
    fn is_over(&self) -> bool {
        self.stopped.load(Ordering::Relaxed) || self.ends.is_some_and(|ends| Instant::now() >= ends)
    }

    /// Counts and writes.
    fn take(&mut self, news: &News) -> Result<(), Failed> {
        self.tally = news.tally;
        if let What::Event(Event::Frame(Frame::Results(frame))) = &news.what {
            self.watch.results(frame);
        }
        match &mut self.out {
            Some((out, _)) => Ok(out.take(news)?),
            None => Ok(()),
        }
    }

    /// How it goes since the last report, if that was `every` ago.
    fn report(&mut self, every: Duration) -> Result<Option<Report>, Failed> {
        let report = self.watch.report(every, self.tally);
        if let (Some(_), Some((Out::Parquet(parts), _))) = (&report, &mut self.out) {
            parts.write_if_due()?;
        }
        Ok(report)
    }

    /// How many results are written, and where.
    fn written(&self) -> Option<(u64, String)> {
        let (out, path) = self.out.as_ref()?;
        let results = match out {
            Out::Csv(recorder) => recorder.written(),
            Out::Parquet(parts) => parts.written(),
        };
        Some((results, printable_path(path).to_string()))
    }

    /// Writes the rest, and says in the end how it went.
    fn end(mut self) -> Result<(), Failed> {
        let rest = match &mut self.out {
            Some((Out::Parquet(parts), _)) => parts.end(),
            Some((Out::Csv(_), _)) | None => Ok(()),
        };
        if let Some(report) = self.report(Duration::ZERO)? {
            println!("{report}");
        }
        if let Some((results, path)) = self.written() {
            println!("{results} results in {path}");
        }
        Ok(rest?)
    }
}

/// Where counts go, and losses beside them.
enum Out {
    Csv(Recorder<File>),
    Parquet(Parts),
}

impl Out {
    fn take(&mut self, news: &News) -> Result<(), RecordError> {
        let time_s = news.time_s;
        match (&news.what, self) {
            (What::Event(Event::Frame(Frame::Results(frame))), Out::Csv(recorder)) => {
                recorder.results(frame, time_s)
            }
            (What::Event(Event::Frame(Frame::Results(frame))), Out::Parquet(parts)) => {
                parts.results(frame, time_s)
            }
            (What::Event(Event::Lost(loss)), Out::Csv(recorder)) => recorder.loss(loss, time_s),
            (What::Event(Event::Lost(loss)), Out::Parquet(parts)) => parts.loss(loss, time_s),
            (What::Back, Out::Csv(recorder)) => {
                recorder.interrupted();
                Ok(())
            }
            (What::Back, Out::Parquet(parts)) => {
                parts.interrupted();
                Ok(())
            }
            // Answers to requests that were sent twice.
            (What::Event(Event::Frame(_)) | What::Gone(_), _) => Ok(()),
        }
    }
}

/// A file that is not there yet.
fn fresh(path: &Path) -> Result<File, Failed> {
    OpenOptions::new().write(true).create_new(true).open(path).map_err(|error| {
        let advice = match error.kind() {
            io::ErrorKind::AlreadyExists => "; name another file, or remove it",
            _ => "",
        };
        format!("{}: {error}{advice}", printable_path(path)).into()
    })
}

/// Whether a file of this name can be made, and is not there yet.
pub(crate) fn check_free(path: &Path) -> Result<(), Failed> {
    drop(fresh(path)?);
    Ok(fs::remove_file(path)?)
}

/// Says each second how it goes, until the time is over or the device is gone.
pub(crate) fn record(line: &Line, recording: &Recording) -> Result<(), Failed> {
    let (device, identity) = line.open()?;
    println!("{}", description(&identity));
    let mut session = Session::new(identity, recording)?;
    let feed = Feed::start(device, identity, None);
    let told = tell(&mut session, &feed);
    // What waits is written, whatever ended it.
    let ended = session.end();
    told.and(ended)
}

fn tell(session: &mut Session, feed: &Feed) -> Result<(), Failed> {
    while !session.is_over() {
        if let Some(news) = feed.next(AT_ONCE) {
            session.take(&news)?;
            if let What::Gone(error) = news.what {
                return Err(error.into());
            }
        }
        if let Some(report) = session.report(REPORTED)? {
            println!("{report}");
        }
    }
    Ok(())
}

/// Shows what comes until the user wants no more; a device that is unplugged is waited for.
pub(crate) fn watch(line: &Line, recording: &Recording) -> Result<(), Failed> {
    if !io::stdout().is_terminal() {
        return Err("`watch` needs a terminal; `record` says the same in lines".into());
    }
    let (device, identity) = line.open()?;
    let ranging = line.scene.as_deref().map(Sensor::load).transpose()?;
    // What comes is of sums where the board adds scans up.
    let ranging = ranging.map(|sensor| Ranging::new(sensor.summed()));
    let mut session = Session::new(identity, recording)?;
    let mut view =
        View::new(&line.port, line.baud, identity, ranging.as_ref().map(Ranging::sensor));
    let again = line.clone();
    let reopen: Reopen<_> = Box::new(move || again.open());
    let feed = Feed::start(device, identity, Some(reopen));
    let mut screen = Screen::new()?;
    let shown =
        show(&mut session, &mut view, &feed, &mut screen, ranging.map(RangingThread::start));
    drop(screen);
    let ended = session.end();
    shown.and(ended)
}

fn show(
    session: &mut Session,
    view: &mut View,
    feed: &Feed,
    screen: &mut Screen,
    ranger: Option<RangingThread>,
) -> Result<(), Failed> {
    let mut scans = Scans::new(view.identity());
    let (mut heard, mut drawn) = (Instant::now(), None::<Instant>);
    while !session.is_over() {
        if let Some(news) = feed.next(AT_ONCE) {
            session.take(&news)?;
            heard = Instant::now();
            match news.what {
                What::Event(Event::Frame(Frame::Results(frame))) => {
                    view.set_state(State::Listening);
                    if let Some(scan) = scans.take(&frame, news.time_s) {
                        ranger.iter().for_each(|ranger| ranger.offer(&scan));
                        view.set_scan(scan);
                    }
                }
                What::Event(Event::Lost(_)) => scans.lost(),
                What::Event(Event::Frame(_)) => {}
                What::Gone(error) => view.set_state(State::Gone(error.to_string())),
                What::Back => {
                    scans.interrupted();
                    view.set_state(State::Listening);
                }
            }
        }
        let answers = ranger.iter().flat_map(|ranger| ranger.answers.try_iter());
        answers.for_each(|answers| view.set_answers(answers));
        if drawn.is_some_and(|drawn| drawn.elapsed() < DRAWN) {
            continue;
        }
        drawn = Some(Instant::now());
        if heard.elapsed() > SILENT && !view.is_gone() {
            view.set_state(State::Silent);
        }
        if let Some(report) = session.report(REPORTED)? {
            view.set_report(report, session.written());
        }
        while event::poll(Duration::ZERO)? {
            if let Terminal::Key(key) = event::read()?
                && ends(view, key)
            {
                return Ok(());
            }
        }
        screen.terminal.draw(|frame| view.draw(frame))?;
    }
    Ok(())
}

/// Whether a key ends the view; what else it may want is done.
fn ends(view: &mut View, key: KeyEvent) -> bool {
    match key.code {
        KeyCode::Char('q') | KeyCode::Esc => return true,
        KeyCode::Char('c') if key.modifiers.contains(KeyModifiers::CONTROL) => return true,
        KeyCode::Char('c') => view.clear(),
        KeyCode::Char('z') => view.zoom(),
        _ => {}
    }
    false
}

/// The terminal, which is as it was when this goes.
struct Screen {
    terminal: DefaultTerminal,
}

impl Screen {
    fn new() -> io::Result<Screen> {
        Ok(Screen { terminal: ratatui::try_init()? })
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        ratatui::restore();
    }
}

/// Ranges scans in a thread of its own: as many as it can, the newest ones.
struct RangingThread {
    scans: SyncSender<Scan>,
    answers: Receiver<Answers>,
}

impl RangingThread {
    fn start(ranging: Ranging) -> RangingThread {
        let (scans, taken) = sync_channel::<Scan>(1);
        let (given, answers) = channel();
        thread::spawn(move || {
            let ranger = ranging.ranger();
            for scan in taken {
                let answer = Answers { scan: scan.number, of: ranger.range(&scan) };
                if given.send(answer).is_err() {
                    return;
                }
            }
        });
        RangingThread { scans, answers }
    }

    fn offer(&self, scan: &Scan) {
        match self.scans.try_send(scan.clone()) {
            // It is busy, and takes a later one.
            Ok(()) | Err(TrySendError::Full(_) | TrySendError::Disconnected(_)) => {}
        }
    }
}
