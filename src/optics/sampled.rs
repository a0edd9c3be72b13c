#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pulse { pub first: u64, pub end: u64 }
pub struct PulseStream {}
impl PulseStream { pub fn new(_s: &crate::scene::Scene, _d: usize, _seed: u64, _r: u64)->Self{PulseStream{}}
 pub fn advance(&mut self, _until: u64, _out: &mut Vec<Pulse>) {} }
