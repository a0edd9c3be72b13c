use goldtof_wire::{Content, Identity, ResultsFrame};

/// A count at its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Row {
    /// Number of the scan since the host began to listen.
    pub scan: u64,
    /// Number of the detector in the scene.
    pub detector: u64,
    /// Phase step of the code period; of a histogram the bin.
    pub phase_step: u64,
    /// The count.
    pub count: i64,
    /// Hits up and down together, where the hardware sends them.
    pub total: Option<u64>,
}

/// The largest of counts that come one after another.
#[derive(Debug, Clone, Default)]
pub struct Largest {
    /// Phase step and count.
    largest: Option<(u64, i64)>,
    least: i64,
    counts: u64,
}

impl Largest {
    /// Takes a count.
    pub fn take(&mut self, phase_step: u64, count: i64) {
        self.least = if self.counts == 0 { count } else { self.least.min(count) };
        self.counts += 1;
        if self.largest.is_none_or(|(_, largest)| count > largest) {
            self.largest = Some((phase_step, count));
        }
    }

    /// Phase step and count of it; none where nothing stands out: every count is the same, or the only one
    /// is 0.
    pub fn peak(&self) -> Option<(u64, i64)> {
        let rest = if self.counts > 1 { self.least } else { 0 };
        self.largest.filter(|&(_, largest)| largest != rest)
    }
}

/// Puts the results of frames at their places.
#[derive(Debug, Clone)]
pub struct Places {
    identity: Identity,
    scan: u64,
    next_index: u64,
}

impl Places {
    /// Before the first frame.
    pub fn new(identity: Identity) -> Places {
        Places { identity, scan: 0, next_index: 0 }
    }

    /// Number of the scan whose results come next.
    pub fn scan(&self) -> u64 {
        self.scan
    }

    /// Whether rows have a total count.
    pub fn has_totals(&self) -> bool {
        self.identity.layout.more_bits > 0 && self.identity.content == Content::Counts
    }

    /// The line was interrupted: what comes next is of another scan.
    pub fn interrupted(&mut self) {
        if self.next_index > 0 {
            self.scan += 1;
            self.next_index = 0;
        }
    }

    /// Gives each count of a frame to `each`.
    pub fn rows(&mut self, frame: &ResultsFrame, mut each: impl FnMut(Row)) {
        let index = u64::from(frame.index);
        // A scan whose end is missing ends where another one begins.
        if index < self.next_index {
            self.scan += 1;
        }
        let Identity { layout, content, samples_per_chip, .. } = self.identity;
        for (&result, index) in frame.results.iter().zip(index..) {
            let (detector, step) = self.identity.place(index);
            let mut row = |phase_step: u64, count: i64, total: Option<u64>| {
                each(Row { scan: self.scan, detector, phase_step, count, total });
            };
            match content {
                Content::Counts => {
                    let total = (layout.more_bits > 0).then(|| layout.more(result));
                    row(self.identity.phase_step(step), layout.count(result, 0), total);
                }
                Content::Rows => {
                    for k in 0..layout.counts {
                        let bin = step * u64::from(samples_per_chip) + u64::from(k);
                        row(bin, layout.unsigned_count(result, k) as i64, None);
                    }
                }
                Content::Peaks => row(layout.more(result), layout.count(result, 0), None),
            }
        }
        self.next_index = index + frame.results.len() as u64;
        if frame.last {
            self.scan += 1;
            self.next_index = 0;
        }
    }
}

/// One detector's counts of a whole scan, in the order in which they were measured.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct DetectorScan {
    /// Phase step of each count; of a histogram its bin.
    pub phase_steps: Vec<u64>,
    /// The counts.
    pub counts: Vec<i64>,
    /// Hits up and down together, where the hardware sends them; else empty.
    pub totals: Vec<u64>,
}

/// A scan all of whose results came.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Scan {
    /// Its number since the host began to listen; those that did not come whole have numbers, too.
    pub number: u64,
    /// When its last result came, in seconds since 1970.
    pub time_s: f64,
    /// Its counts, detector by detector.
    pub detectors: Vec<DetectorScan>,
}

/// Takes frames, and gives the scans that came whole.
#[derive(Debug, Clone)]
pub struct Scans {
    places: Places,
    results_of_scan: u64,
    detectors: usize,
    /// The scan that is coming, and the place of its next result; no place once one is missing.
    coming: Scan,
    next_index: Option<u64>,
}

impl Scans {
    /// Before the first frame.
    pub fn new(identity: Identity) -> Scans {
        Scans {
            places: Places::new(identity),
            results_of_scan: identity.results_of_scan(),
            detectors: usize::from(identity.detectors),
            coming: Scan::default(),
            next_index: None,
        }
    }

    /// Something is missing: the scan that is coming is not whole, even if a later one goes on at its place.
    pub fn lost(&mut self) {
        self.next_index = None;
    }

    /// The line was interrupted: what comes next is of another scan.
    pub fn interrupted(&mut self) {
        self.places.interrupted();
        self.lost();
    }

    /// Takes a frame that came at `time_s`; gives the scan that it completes.
    pub fn take(&mut self, frame: &ResultsFrame, time_s: f64) -> Option<Scan> {
        if frame.index == 0 {
            self.next_index = Some(0);
            self.coming = Scan {
                number: self.places.scan(),
                time_s,
                detectors: vec![DetectorScan::default(); self.detectors],
            };
        }
        let follows = self.next_index == Some(u64::from(frame.index));
        let coming = &mut self.coming;
        self.places.rows(frame, |row| {
            let Some(of) = coming.detectors.get_mut(row.detector as usize).filter(|_| follows)
            else {
                return;
            };
            coming.number = row.scan;
            of.phase_steps.push(row.phase_step);
            of.counts.push(row.count);
            of.totals.extend(row.total);
        });
        let reached = u64::from(frame.index) + frame.results.len() as u64;
        self.next_index = follows.then_some(reached);
        let is_whole = frame.last && follows && reached == self.results_of_scan;
        is_whole.then(|| {
            self.next_index = None;
            self.coming.time_s = time_s;
            std::mem::take(&mut self.coming)
        })
    }
}
