//! The reference model, clocked in batches.

use std::collections::VecDeque;
use std::ffi::{CString, c_char};
use std::sync::Mutex;

use goldtof::batch::{self, BatchInputs, HostInputs, Model};

use crate::border::{array, call, free, handle, locked, new_handle, status_of};
use crate::scene::SceneHandle;
use crate::status::{Failure, Status};

/// A model, its ports' names, and results that were not taken yet.
pub(crate) struct OpenModel {
    model: Model,
    names: Vec<CString>,
    outputs: Vec<u64>,
    results: VecDeque<StepResult>,
}

/// A reference model.
pub struct ModelHandle(Mutex<OpenModel>);

handle!(ModelHandle, OpenModel);

/// An output port, and where its bits lie in a clock's record.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct Port {
    /// Its name, for as long as the model lives.
    pub name: *const c_char,
    /// Bits.
    pub width: u32,
    /// The record's word of its bit 0. A port wider than 64 bits has whole words, the
    /// lowest first.
    pub word: u32,
    /// The bit in that word.
    pub shift: u32,
}

/// A phase step whose integration is over.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct StepResult {
    /// The clock after whose rising edge its group comes to the stream, if nothing
    /// stands there any more.
    pub clock: u64,
    /// Number of the scan since the last reset.
    pub scan: u64,
    /// Number of the step within the scan.
    pub step: u64,
    /// The signed count, saturated as the hardware does.
    pub count: i64,
    /// Hits counted, up and down together.
    pub total: u64,
    /// Number of the detector.
    pub detector: u32,
}

/// A model of the hardware of a scene's sensor before its first clock; null if there is
/// none. Its results come `result_latency_clocks` after a group's last word, and peaks
/// `peak_latency_clocks` after a scan's; below 0, as late as those of the emitted design.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn goldtof_model_new(
    scene: *const SceneHandle,
    result_latency_clocks: i32,
    peak_latency_clocks: i32,
) -> *mut ModelHandle {
    new_handle(|| {
        // SAFETY: the caller's word.
        let sensor = unsafe { locked(scene, "scene") }?.sensor();
        let sensor = batch::held_to(
            &sensor,
            u32::try_from(result_latency_clocks).ok(),
            u32::try_from(peak_latency_clocks).ok(),
        )
        .map_err(Failure::invalid)?;
        let model = Model::new(&sensor).map_err(Failure::invalid)?;
        let fields = model.layout().outputs.fields.iter();
        let names = fields.map(|field| CString::new(field.port.name.as_str()).unwrap_or_default());
        Ok(OpenModel {
            names: names.collect(),
            model,
            outputs: Vec::new(),
            results: VecDeque::new(),
        })
    })
}

/// Ends a model.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn goldtof_model_free(model: *mut ModelHandle) {
    // SAFETY: the caller's word.
    unsafe { free(model) }
}

/// Number of detectors; 0 if the handle is bad.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn goldtof_model_detectors(model: *const ModelHandle) -> u32 {
    // SAFETY: the caller's word.
    let number = call(|| {
        let model = unsafe { locked(model, "model") }?;
        Ok(model.model.interface().reference_codes.len() as u32)
    });
    number.unwrap_or(0)
}

/// Number of sample words of a clock: one for each detector, or for each of its cells if these have an
/// input each; 0 if the handle is bad.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn goldtof_model_inputs(model: *const ModelHandle) -> u32 {
    // SAFETY: the caller's word.
    let number = call(|| {
        let model = unsafe { locked(model, "model") }?;
        Ok(model.model.interface().inputs() as u32)
    });
    number.unwrap_or(0)
}

/// Words of 64 bits of a clock's record of outputs; 0 if the handle is bad.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn goldtof_model_words(model: *const ModelHandle) -> u32 {
    // SAFETY: the caller's word.
    let words = call(|| {
        let model = unsafe { locked(model, "model") }?;
        Ok(model.model.layout().outputs.words as u32)
    });
    words.unwrap_or(0)
}

/// Number of output ports; 0 if the handle is bad.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn goldtof_model_ports(model: *const ModelHandle) -> u32 {
    // SAFETY: the caller's word.
    let ports = call(|| Ok(unsafe { locked(model, "model") }?.names.len() as u32));
    ports.unwrap_or(0)
}

/// Tells of output port number `index`, in the order of the Verilog.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn goldtof_model_port(
    model: *const ModelHandle,
    index: u32,
    port: *mut Port,
) -> Status {
    status_of(|| {
        // SAFETY: the caller's word.
        let model = unsafe { locked(model, "model") }?;
        let fields = &model.model.layout().outputs.fields;
        let Some(field) = fields.get(index as usize) else {
            let there = fields.len();
            return Err(Failure::invalid(format!(
                "there is no output port {index}; there are {there}, from 0 on"
            )));
        };
        let told = Port {
            name: model.names[index as usize].as_ptr(),
            width: field.port.width,
            word: field.word as u32,
            shift: field.shift,
        };
        // SAFETY: the caller's word.
        match unsafe { port.as_mut() } {
            Some(port) => *port = told,
            None => return Err(Failure::invalid("the place for the port is a null pointer")),
        }
        Ok(())
    })
}

/// What a host drives at the AXI4-Lite slave of a design with registers, at a clock.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct Host {
    /// `s_axil_wdata`.
    pub write_data: u32,
    /// `s_axil_awaddr`.
    pub write_address: u16,
    /// `s_axil_araddr`.
    pub read_address: u16,
    /// `s_axil_wstrb`.
    pub write_strobe: u8,
    /// `s_axil_awvalid`; this and those below are 0 for low.
    pub write_address_valid: u8,
    /// `s_axil_wvalid`.
    pub write_valid: u8,
    /// `s_axil_bready`.
    pub write_response_ready: u8,
    /// `s_axil_arvalid`.
    pub read_address_valid: u8,
    /// `s_axil_rready`.
    pub read_ready: u8,
}

/// Clocks the model through a batch; its state stays for the next one. `samples` has
/// goldtof_model_inputs() words for each clock, bit 0 the earliest sample. `reset` and `ready`
/// have a byte for each clock, 0 for low; null stands for low and for high at all clocks.
/// `outputs` gets goldtof_model_words() words for each clock: what the ports show after
/// its rising edge. If an input is wrong, nothing has changed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn goldtof_model_clock(
    model: *mut ModelHandle,
    clocks: usize,
    samples: *const u64,
    reset: *const u8,
    ready: *const u8,
    outputs: *mut u64,
) -> Status {
    // SAFETY: the caller's word, and there is no host.
    unsafe {
        goldtof_model_clock_hosted(model, clocks, samples, reset, ready, std::ptr::null(), outputs)
    }
}

/// The same of a design with registers, whose `host` drives something at each clock; null stands for
/// zeros at all of them.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn goldtof_model_clock_hosted(
    model: *mut ModelHandle,
    clocks: usize,
    samples: *const u64,
    reset: *const u8,
    ready: *const u8,
    host: *const Host,
    outputs: *mut u64,
) -> Status {
    status_of(|| {
        // SAFETY: the caller's word.
        let mut model = unsafe { locked(model, "model") }?;
        let OpenModel { model, outputs: records, results, .. } = &mut *model;
        let inputs = model.interface().inputs();
        let given = |is_null: bool| if is_null { 0 } else { clocks };
        if outputs.is_null() && clocks > 0 {
            return Err(Failure::invalid("the place for the outputs is a null pointer"));
        }
        let too_many = || Failure::invalid(format!("{clocks} clocks are too many for one batch"));
        let words = clocks.checked_mul(inputs).ok_or_else(too_many)?;
        // SAFETY: the caller's word.
        let driven = unsafe { array(host, given(host.is_null()), "the host's array") }?;
        let driven: Vec<HostInputs> = driven.iter().map(Host::inputs).collect();
        // SAFETY: the caller's word.
        let inputs = unsafe {
            BatchInputs {
                samples: array(samples, words, "the array of samples")?,
                reset: array(reset, given(reset.is_null()), "the array of resets")?,
                ready: array(ready, given(ready.is_null()), "the array of ready")?,
                host: &driven,
            }
        };
        model.clock(&inputs, records).map_err(Failure::invalid)?;
        if !outputs.is_null() {
            // SAFETY: the caller's word.
            unsafe { outputs.copy_from_nonoverlapping(records.as_ptr(), records.len()) };
        }
        results.extend(model.take_results().map(StepResult::of));
        Ok(())
    })
}

/// Takes up to `room` results of the clocks so far, in order, and gives their number;
/// with null for `results`, how many there are.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn goldtof_model_take_results(
    model: *mut ModelHandle,
    results: *mut StepResult,
    room: usize,
) -> usize {
    let taken = call(|| {
        // SAFETY: the caller's word.
        let mut model = unsafe { locked(model, "model") }?;
        if results.is_null() {
            return Ok(model.results.len());
        }
        let taken = room.min(model.results.len());
        for (place, result) in model.results.drain(..taken).enumerate() {
            // SAFETY: there is room, the caller says.
            unsafe { results.add(place).write(result) };
        }
        Ok(taken)
    });
    taken.unwrap_or(0)
}

impl Host {
    fn inputs(&self) -> HostInputs {
        HostInputs {
            write_address_valid: self.write_address_valid != 0,
            write_address: self.write_address,
            write_valid: self.write_valid != 0,
            write_data: self.write_data,
            write_strobe: self.write_strobe,
            write_response_ready: self.write_response_ready != 0,
            read_address_valid: self.read_address_valid != 0,
            read_address: self.read_address,
            read_ready: self.read_ready != 0,
        }
    }
}

impl StepResult {
    fn of(result: batch::StepResult) -> StepResult {
        StepResult {
            clock: result.clock,
            scan: result.scan,
            step: result.step,
            count: result.count,
            total: result.total,
            detector: result.detector.0 as u32,
        }
    }
}
