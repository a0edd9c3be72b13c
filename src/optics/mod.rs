pub mod sampled;
