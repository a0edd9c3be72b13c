//! A module round `sensor_top` that states what it has to do.

use std::fmt::Write as _;

use crate::deliver::design::Design;
use crate::sensor::interface::{Direction, Interface, Port};

/// A proof: the design, some of its inner ports seen or cut, and what is to hold.
#[derive(Debug, Clone)]
pub(super) struct Harness {
    /// Name of the proof and of its task.
    pub(super) name: &'static str,
    /// What it proves, for the file's comment.
    about: String,
    engine: Engine,
    start: Start,
    ports: Vec<Port>,
    seen: Vec<Inner>,
    cut: Vec<Inner>,
    /// Modules that have their ports only, so that their outputs can be driven.
    emptied: Vec<&'static str>,
    /// Modules whose outputs may be anything at any clock.
    freed: Vec<&'static str>,
    body: String,
    /// What is to hold at every clock, for [`Engine::Steps`].
    held: Vec<String>,
    /// What its conditions ask for: all of it can be at once.
    reached: Vec<String>,
}

/// Where a proof starts from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Start {
    /// As reset leaves the registers.
    AfterReset,
    /// Any state of the registers, with i_rst high.
    InReset,
    /// Any state of the registers in which all that is to hold does.
    Anywhere,
}

/// How a proof is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Engine {
    /// A search through the first clocks after reset, induction over four clocks with all
    /// equivalences of design and specification as hypotheses, then property directed reachability for what is left.
    Induction,
    /// Property directed reachability alone.
    Reachability,
    /// Induction over so many clocks: from any state on, behind as many in which all that is to
    /// hold does, in reset or not, comes another one. A fault shows within these clocks, however
    /// long the design's counters run before.
    Steps(u32),
    /// No proof but a search through so many clocks after reset.
    Bounded(u32),
}

/// A port inside the design.
#[derive(Debug, Clone)]
struct Inner {
    /// Name of the signal in the harness.
    signal: String,
    /// Where it is below `sensor_top`: instances and port.
    path: String,
    width: u32,
}

impl Harness {
    pub(super) fn new(interface: &Interface, name: &'static str, about: &str) -> Harness {
        Harness {
            name,
            about: about.to_owned(),
            engine: Engine::Induction,
            start: Start::AfterReset,
            ports: interface.ports(),
            seen: Vec::new(),
            cut: Vec::new(),
            emptied: Vec::new(),
            freed: Vec::new(),
            body: String::new(),
            held: Vec::new(),
            reached: Vec::new(),
        }
    }

    pub(super) fn engine(mut self, engine: Engine) -> Harness {
        self.engine = engine;
        if let Engine::Steps(_) = engine {
            self.start = Start::Anywhere;
        }
        self
    }

    /// Keeps i_rst high, and starts from any state.
    pub(super) fn in_reset(mut self) -> Harness {
        self.start = Start::InReset;
        self
    }

    /// The macro with which the registers are mapped; none where they are as they are.
    pub(super) fn register_map(&self) -> Option<&'static str> {
        match self.start {
            Start::AfterReset => Some(""),
            Start::InReset => Some("-D IN_RESET "),
            Start::Anywhere => None,
        }
    }

    /// Says what is to hold at every clock, of a proof by [`Engine::Steps`].
    pub(super) fn holds(&mut self, what: &str) {
        self.held.push(what.to_owned());
    }

    /// Says what has to be for assertions to say anything.
    pub(super) fn reaches(&mut self, condition: &str) {
        self.reached.push(condition.to_owned());
    }

    /// Name of the task that looks whether its assertions can be reached; none where they ask
    /// for nothing.
    pub(super) fn cover_task(&self) -> Option<String> {
        let asks = self.proof_by_steps().is_some() || !self.reached.is_empty();
        asks.then(|| format!("{}_cover", self.name))
    }

    /// Clocks within which they are.
    pub(super) fn cover_depth(&self) -> u32 {
        self.proof_by_steps().unwrap_or(2) + 2
    }

    fn proof_by_steps(&self) -> Option<u32> {
        match self.engine {
            Engine::Steps(clocks) => Some(clocks),
            _ => None,
        }
    }

    /// Under COVER: what is to be reached, said not to be, so that the task shows how it is.
    fn cover(&self) -> String {
        let steps = self.proof_by_steps().map(|clocks| format!("clocks == {clocks} & held"));
        let all: Vec<String> = steps.into_iter().chain(self.reached.iter().cloned()).collect();
        match all.is_empty() {
            true => String::new(),
            false => format!(
                "`ifdef COVER\n    always @* assume (~(({})));\n`endif\n",
                all.join(") & (")
            ),
        }
    }

    /// The assertions of a proof by [`Engine::Steps`].
    fn assertions(&self) -> String {
        let mut text = String::new();
        if self.held.is_empty() {
            return text;
        }
        let count = self.held.len();
        let _ = writeln!(
            text,
            "\n    // What holds at every clock.\n    wire {}holds;",
            range(count as u32)
        );
        for (number, what) in self.held.iter().enumerate() {
            let place = if count == 1 { String::new() } else { format!("[{number}]") };
            let _ = writeln!(text, "    assign holds{place} = {what};");
        }
        let Some(clocks) = self.proof_by_steps() else {
            return text;
        };
        let bits = u32::BITS - clocks.leading_zeros();
        let _ = write!(
            text,
            "    // Registers are anything at first, but such that all of it holds for {clocks} clock{plural}.\n    \
             reg {range}clocks = 0;\n    \
             reg held;\n    \
             always @(posedge i_clk) begin\n        \
                 clocks <= clocks + (clocks != {clocks});\n        \
                 held <= (held | clocks == 0) & (&holds);\n    \
             end\n    \
             always @* if (clocks == {clocks} & held) assert (&holds);\n",
            plural = if clocks == 1 { "" } else { "s" },
            range = range(bits),
        );
        text
    }

    /// Makes the output `path` of a module inside readable as `signal`.
    pub(super) fn see(&mut self, signal: &str, path: &str, width: u32) {
        self.seen.push(inner(signal, path, width));
    }

    /// Empties the modules `name`: nothing drives their outputs but what is cut.
    pub(super) fn empty(&mut self, name: &'static str) {
        self.emptied.push(name);
    }

    /// Lets the outputs of the modules `name` be anything: what it shows holds whatever
    /// they do, and is not about them.
    pub(super) fn freeing(mut self, name: &'static str) -> Harness {
        self.freed.push(name);
        let _ = write!(self.about, "\nWhat a {name} gives is anything, at any clock.");
        self
    }

    /// Whether any module is there with its ports alone.
    pub(super) fn is_cut(&self) -> bool {
        !(self.emptied.is_empty() && self.freed.is_empty())
    }

    /// Whether the module of this name is there with its ports alone.
    pub(super) fn empties(&self, module: &str) -> bool {
        self.emptied.contains(&block(module)) || self.frees(module)
    }

    /// Whether the outputs of the module of this name may be anything.
    pub(super) fn frees(&self, module: &str) -> bool {
        self.freed.contains(&block(module))
    }

    /// Drives the output `path` of an emptied module with `signal`, which the body
    /// drives.
    pub(super) fn cut(&mut self, signal: &str, path: &str, width: u32) {
        self.cut.push(inner(signal, path, width));
    }

    /// Adds an input that may do anything.
    pub(super) fn free(&mut self, name: &str, width: u32) {
        self.ports.push(Port { name: name.to_owned(), direction: Direction::Input, width });
    }

    /// Adds a line of Verilog.
    pub(super) fn line(&mut self, text: &str) {
        let _ = writeln!(self.body, "    {text}");
    }

    /// Adds Verilog that may have several lines, indented by one level.
    pub(super) fn lines(&mut self, text: &str) {
        for line in text.lines() {
            if line.is_empty() {
                self.body.push('\n');
            } else {
                self.line(line);
            }
        }
    }

    /// Name of its top module.
    pub(super) fn top(&self, design: &Design) -> String {
        design.prefix.of(&format!("prove_{}", self.name))
    }

    /// Its Verilog.
    pub(super) fn text(&self, design: &Design) -> String {
        let mut text = String::new();
        for line in self.about.lines() {
            let _ = writeln!(text, "// {line}");
        }
        let inputs = self.ports.iter().filter(|p| p.direction == Direction::Input);
        let inputs: Vec<String> = inputs
            .map(|port| format!("    input wire {}{}", range(port.width), port.name))
            .collect();
        let _ = writeln!(text, "module {} (\n{}\n);", self.top(design), inputs.join(",\n"));
        for port in self.ports.iter().filter(|p| p.direction == Direction::Output) {
            let _ = writeln!(text, "    wire {}{};", range(port.width), port.name);
        }
        for inner in &self.seen {
            let _ = writeln!(text, "    wire {}{};", range(inner.width), inner.signal);
        }
        let pins: Vec<String> = self
            .ports
            .iter()
            .filter(|port| port.direction == Direction::Output || is_of_design(&port.name))
            .map(|port| match port.name.as_str() {
                "i_rst" if self.start == Start::InReset => "        .i_rst(1'b1)".to_owned(),
                name => format!("        .{name}({name})"),
            })
            .collect();
        let _ = writeln!(text, "    {} dut (\n{}\n    );\n", design.top(), pins.join(",\n"));
        text.push_str(&self.body);
        text.push_str(&self.assertions());
        text.push_str(&self.cover());
        text.push_str("endmodule\n");
        text
    }

    /// Its lines of the `.sby` script, once the design is flat.
    pub(super) fn script(&self, design: &Design) -> Vec<String> {
        let mut lines = Vec::new();
        if !self.seen.is_empty() || !self.cut.is_empty() {
            lines.push(format!("cd {}", self.top(design)));
        }
        for inner in &self.seen {
            let path = inner.path_in(design);
            lines.push(format!("connect -nounset -set {} dut.{path}", inner.signal));
        }
        for inner in &self.cut {
            let path = inner.path_in(design);
            lines.push(format!("connect -nounset -set dut.{path} {}", inner.signal));
        }
        if !lines.is_empty() {
            lines.push("cd ..".to_owned());
        }
        lines
    }

    /// The options of its task.
    pub(super) fn options(&self) -> Vec<String> {
        match self.engine {
            // The clocks before, the one behind them, and one more.
            Engine::Steps(clocks) => {
                vec!["mode bmc".to_owned(), format!("depth {}", clocks + 2)]
            }
            Engine::Bounded(clocks) => vec!["mode bmc".to_owned(), format!("depth {clocks}")],
            Engine::Induction | Engine::Reachability => vec!["mode prove".to_owned()],
        }
    }

    /// The engine's line in the `.sby` file.
    pub(super) fn engine_line(&self) -> &'static str {
        match self.engine {
            // What shows within the pipelines is found at once; scorr and pdr would look long for it.
            Engine::Induction => "abc bmc3 -F 9; scorr -F 4 -C 100000; pdr",
            Engine::Reachability => "abc pdr",
            Engine::Steps(_) | Engine::Bounded(_) => "abc bmc3",
        }
    }
}

impl Inner {
    /// Where it is in the flat design: like channels are made by a loop.
    fn path_in(&self, design: &Design) -> String {
        let top = &design.files[design.files.len() - 1].text;
        let of_loop = |(channel, rest): (&str, &str)| {
            let number = channel.strip_prefix("channel_")?;
            Some(format!("gen_channel[{number}].channel.{rest}"))
        };
        let looped = match top.contains("begin : gen_channel") {
            true => self.path.split_once('.').and_then(of_loop),
            false => None,
        };
        looped.unwrap_or_else(|| self.path.clone())
    }
}

/// The block that a module is one of: those that differ have a number at the end.
fn block(module: &str) -> &str {
    match module.rsplit_once('_') {
        Some((block, number)) if number.bytes().all(|b| b.is_ascii_digit()) => block,
        _ => module,
    }
}

fn inner(signal: &str, path: &str, width: u32) -> Inner {
    Inner { signal: signal.to_owned(), path: path.to_owned(), width }
}

/// Whether an input is one of `sensor_top` and not one that the harness adds.
fn is_of_design(name: &str) -> bool {
    matches!(name, "i_clk" | "i_rst" | "i_samples" | "m_axis_tready")
}

/// A range before a name, empty for one bit.
pub(super) fn range(width: u32) -> String {
    match width {
        1 => String::new(),
        _ => format!("[{}:0] ", width - 1),
    }
}

/// The name of the `index`-th of `count` instances or ports called `base`.
pub(super) fn numbered(base: &str, index: u32, count: u32) -> String {
    match count {
        1 => base.to_owned(),
        _ => format!("{base}_{index}"),
    }
}

/// The `index`-th of `count` elements of a port, of `width` bits each.
pub(super) fn element(port: &str, index: u32, count: u32, width: u32) -> String {
    let low = index * width;
    match (count, width) {
        (1, _) => port.to_owned(),
        (_, 1) => format!("{port}[{low}]"),
        _ => format!("{port}[{}:{low}]", low + width - 1),
    }
}

/// A constant of `width` bits.
pub(super) fn constant(width: u32, value: u128) -> String {
    format!("{width}'h{value:x}")
}
