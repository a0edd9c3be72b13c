//! A scoreboard that a testbench feeds word by word.
//!
//! All that crosses here is what DPI-C takes everywhere: chandle, int, longint, string.

use std::ffi::{CString, c_char};
use std::sync::Mutex;

use goldtof::batch::{Scoreboard, ScoreboardOptions, TestbenchPort};
use goldtof::cosim::Verdict;
use goldtof::sensor::Sensor;

use crate::border::{array, call, free, handle, locked, new_handle, status_of, text};
use crate::scene::SceneHandle;
use crate::status::{Failure, Status};

/// A scoreboard, and what is known of the testbench while there is none yet.
pub(crate) struct OpenScoreboard {
    sensor: Sensor,
    options: ScoreboardOptions,
    ports: Vec<TestbenchPort>,
    scoreboard: Option<Scoreboard>,
    report: CString,
}

/// A scoreboard.
pub struct ScoreboardHandle(Mutex<OpenScoreboard>);

handle!(ScoreboardHandle, OpenScoreboard);

impl OpenScoreboard {
    fn begun(&mut self) -> Result<&mut Scoreboard, Failure> {
        if self.scoreboard.is_none() {
            let scoreboard = Scoreboard::new(&self.sensor, &self.ports, self.options);
            self.scoreboard = Some(scoreboard.map_err(Failure::invalid)?);
        }
        let begun = self.scoreboard.as_mut();
        begun.ok_or_else(|| Failure::invalid("the scoreboard has not begun"))
    }
}

/// In place of a result's latency: the design's own, which its first result tells.
pub const GOLDTOF_LATENCY_AUTO: i32 = -2;

/// A scoreboard for a design of this scene; null if there can be none. Latencies are as
/// with goldtof_model_new(), or GOLDTOF_LATENCY_AUTO of results, which keeps the clocks until the first.
/// `batch_clocks` are compared at once: a mismatch is told when
/// the last of them has come.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn goldtof_scoreboard_new(
    scene: *const SceneHandle,
    result_latency_clocks: i32,
    peak_latency_clocks: i32,
    is_idle_payload_free: i32,
    batch_clocks: i32,
) -> *mut ScoreboardHandle {
    new_handle(|| {
        // SAFETY: the caller's word.
        let sensor = unsafe { locked(scene, "scene") }?.sensor();
        let batch_clocks = u32::try_from(batch_clocks).ok().filter(|&clocks| clocks > 0);
        let options = ScoreboardOptions {
            result_latency_clocks: u32::try_from(result_latency_clocks).ok(),
            peak_latency_clocks: u32::try_from(peak_latency_clocks).ok(),
            finds_latency: result_latency_clocks == GOLDTOF_LATENCY_AUTO,
            is_idle_payload_free: is_idle_payload_free != 0,
            batch_clocks: batch_clocks
                .ok_or_else(|| Failure::invalid("a batch has at least 1 clock"))?,
        };
        Ok(OpenScoreboard {
            sensor,
            options,
            ports: Vec::new(),
            scoreboard: None,
            report: CString::default(),
        })
    })
}

/// Tells the next port of the testbench's record: its bits stand behind those of the one
/// before it, the first at bit 0 of the first word. All ports are told before the first
/// clock; an output that this scene's sensor does not have is passed over.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn goldtof_scoreboard_port(
    scoreboard: *mut ScoreboardHandle,
    name: *const c_char,
    width: i32,
) -> Status {
    status_of(|| {
        // SAFETY: the caller's word.
        let (mut scoreboard, name) =
            unsafe { (locked(scoreboard, "scoreboard")?, text(name, "the port's name")?) };
        if scoreboard.scoreboard.is_some() {
            return Err(Failure::invalid(format!(
                "port {name} comes behind the first clock; tell all ports before it"
            )));
        }
        let width = u32::try_from(width).ok().filter(|&width| width > 0);
        let width =
            width.ok_or_else(|| Failure::invalid(format!("port {name} has at least 1 bit")))?;
        scoreboard.ports.push(TestbenchPort { name: name.to_owned(), width });
        Ok(())
    })
}

/// Ends the telling of ports, and gives the words of a clock's record; 0 if the ports are
/// not the sensor's.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn goldtof_scoreboard_begin(scoreboard: *mut ScoreboardHandle) -> i32 {
    let words = call(|| {
        // SAFETY: the caller's word.
        let mut scoreboard = unsafe { locked(scoreboard, "scoreboard") }?;
        Ok(scoreboard.begun()?.words() as i32)
    });
    words.unwrap_or(0)
}

/// Takes the next word of the present clock's record: the inputs before the clock's
/// rising edge, and the outputs after it. GOLDTOF_STATUS_MISMATCH once a port was found
/// to differ; goldtof_scoreboard_report() says which, where and how.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn goldtof_scoreboard_word(
    scoreboard: *mut ScoreboardHandle,
    word: u64,
) -> Status {
    // SAFETY: the caller's word, and one word stands there.
    unsafe { goldtof_scoreboard_words(scoreboard, &raw const word, 1) }
}

/// Takes the next words of records, as goldtof_scoreboard_word() does one by one: of some
/// clocks, whole ones or not, in one call.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn goldtof_scoreboard_words(
    scoreboard: *mut ScoreboardHandle,
    words: *const u64,
    count: i32,
) -> Status {
    let status = call(|| {
        // SAFETY: the caller's word.
        let mut scoreboard = unsafe { locked(scoreboard, "scoreboard") }?;
        let count = usize::try_from(count)
            .map_err(|_| Failure::invalid(format!("count is {count}, and has to be 0 or more")))?;
        // SAFETY: the caller's word.
        let words = unsafe { array(words, count, "words") }?;
        let scoreboard = scoreboard.begun()?;
        scoreboard.push(words);
        Ok(match scoreboard.first_mismatch() {
            Some(_) => Status::Mismatch,
            None => Status::Ok,
        })
    });
    status.unwrap_or_else(|status| status)
}

/// Compares what has come, and judges: GOLDTOF_STATUS_OK, _MISMATCH, or _INCONCLUSIVE if
/// too little has happened to tell.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn goldtof_scoreboard_verdict(scoreboard: *mut ScoreboardHandle) -> Status {
    let status = call(|| {
        // SAFETY: the caller's word.
        let mut scoreboard = unsafe { locked(scoreboard, "scoreboard") }?;
        Ok(match scoreboard.begun()?.summary().verdict {
            Verdict::Match => Status::Ok,
            Verdict::Mismatch => Status::Mismatch,
            Verdict::Inconclusive => Status::Inconclusive,
        })
    });
    status.unwrap_or_else(|status| status)
}

/// What was compared and found, in words: verdict, the first mismatch with clock, time,
/// port, expected and got, and what was exercised. Valid until the next call of this
/// function with this scoreboard, or its end; null if the handle is bad.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn goldtof_scoreboard_report(
    scoreboard: *mut ScoreboardHandle,
) -> *const c_char {
    let report = call(|| {
        // SAFETY: the caller's word.
        let mut scoreboard = unsafe { locked(scoreboard, "scoreboard") }?;
        let text = scoreboard.begun()?.summary().to_string();
        scoreboard.report = CString::new(text).unwrap_or_default();
        Ok(scoreboard.report.as_ptr())
    });
    report.unwrap_or(std::ptr::null())
}

/// Ends a scoreboard.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn goldtof_scoreboard_free(scoreboard: *mut ScoreboardHandle) {
    // SAFETY: the caller's word.
    unsafe { free(scoreboard) }
}
