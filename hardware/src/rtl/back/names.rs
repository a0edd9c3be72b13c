//! What Verilog allows as a name.

use std::collections::HashSet;
use std::sync::LazyLock;

use super::fault::Fault;

/// Refuses what is not a plain Verilog identifier, or is a keyword of
/// Verilog-2005 or a common one of SystemVerilog.
pub fn check_name(name: &str) -> Result<(), Fault> {
    let refuse = |reason| Err(Fault::BadName { name: name.to_owned(), reason });
    let starts_well = name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_');
    let only_word_characters = name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    if !starts_well || !only_word_characters {
        return refuse("it has other characters than letters, digits and _");
    }
    if KEYWORDS.contains(name) {
        return refuse("it is a keyword");
    }
    Ok(())
}

/// IEEE 1364-2005 Annex B, then the SystemVerilog keywords that read like
/// signal names.
static KEYWORDS: LazyLock<HashSet<&str>> = LazyLock::new(|| {
    "\
    always and assign automatic begin buf bufif0 bufif1 case casex casez cell cmos config \
    deassign default defparam design disable edge else end endcase endconfig endfunction \
    endgenerate endmodule endprimitive endspecify endtable endtask event for force forever \
    fork function generate genvar highz0 highz1 if ifnone incdir include initial inout input \
    instance integer join large liblist library localparam macromodule medium module nand \
    negedge nmos nor noshowcancelled not notif0 notif1 or output parameter pmos posedge \
    primitive pull0 pull1 pulldown pullup pulsestyle_ondetect pulsestyle_onevent rcmos real \
    realtime reg release repeat rnmos rpmos rtran rtranif0 rtranif1 scalared showcancelled \
    signed small specify specparam strong0 strong1 supply0 supply1 table task time tran \
    tranif0 tranif1 tri tri0 tri1 triand trior trireg unsigned use uwire vectored wait wand \
    weak0 weak1 while wire wor xnor xor bit byte logic int longint shortint break continue \
    do return this new static local final global packed ref type string struct union void \
    const checker cover expect first_match matches priority property sequence unique within \
    context class"
        .split(' ')
        .collect()
});

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keywords_and_dollar_names_are_refused() {
        for bad in ["table", "edge", "logic", "u$0", "0u", "a b", ""] {
            assert!(check_name(bad).is_err(), "{bad} must be refused");
        }
        for good in ["u_r", "DWELL_RELOAD", "tables", "_x"] {
            assert!(check_name(good).is_ok(), "{good} must be accepted");
        }
    }
}
