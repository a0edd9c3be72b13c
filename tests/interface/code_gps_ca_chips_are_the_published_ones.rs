//! The LFSR conventions against a published table: GPS C/A is a Gold code.

use goldtof::code::{CodeSpec, Family};

/// Delay of G2 in chips and first ten chips in octal, for PRN 1 to 32
/// (IS-GPS-200, Table 3-Ia).
const PUBLISHED: [(i64, u32); 32] = [
    (5, 0o1440),
    (6, 0o1620),
    (7, 0o1710),
    (8, 0o1744),
    (17, 0o1133),
    (18, 0o1455),
    (139, 0o1131),
    (140, 0o1454),
    (141, 0o1626),
    (251, 0o1504),
    (252, 0o1642),
    (254, 0o1750),
    (255, 0o1764),
    (256, 0o1772),
    (257, 0o1775),
    (258, 0o1776),
    (469, 0o1156),
    (470, 0o1467),
    (471, 0o1633),
    (472, 0o1715),
    (473, 0o1746),
    (474, 0o1763),
    (509, 0o1063),
    (512, 0o1706),
    (513, 0o1743),
    (514, 0o1761),
    (515, 0o1770),
    (516, 0o1774),
    (859, 0o1127),
    (860, 0o1453),
    (861, 0o1625),
    (862, 0o1712),
];

#[test]
fn the_first_ten_chips_of_all_32_satellites_are_the_published_ones() {
    for (prn, (delay, octal)) in (1..).zip(PUBLISHED) {
        let spec = CodeSpec {
            degree: Some(10),
            // A delay by d chips is an advance by the rest of the period.
            index: Some(1023 - delay),
            polynomials: Some(vec![vec![10, 3, 0], vec![10, 9, 8, 6, 3, 2, 0]]),
            ..CodeSpec::new(Family::Gold)
        };
        let code = spec.build().unwrap();
        let first_ten = code.chips[..10].iter().fold(0, |word, &chip| 2 * word + u32::from(chip));
        assert_eq!(first_ten, octal, "PRN {prn}: {first_ten:o}");
        assert_eq!(code.len(), 1023);
    }
}
