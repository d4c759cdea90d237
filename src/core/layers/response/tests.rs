use super::*;
use crate::hemisphere::{mix, texel_centres, unit};
use glam::DVec3;

/// Makes responses of receivers that see patches of a few orientations, each lit from a part of the
/// sky. Every third receiver sees nothing.
fn tile(count: usize, n: usize, scale: f64) -> Vec<Response> {
    let centres = texel_centres(n);
    let texels = n * n;
    let response = |i: usize| {
        let mut values = vec![0.0; Response::len(n)];
        let random = |j: u64| unit(mix(i as u64, j)) * 2.0 - 1.0;
        for patch in 0..(i % 3) as u64 * 4 {
            let at = |k: u64| random(10 * patch + k);
            let normal = DVec3::new(at(0), at(1), at(2)).normalize_or(DVec3::Z);
            let gap = DVec3::new(at(3), at(4), 0.1 - at(5)).normalize_or(DVec3::Z);
            for (t, _) in centres.iter().enumerate().filter(|(_, s)| s.dot(normal) > 0.0 && s.dot(gap) > 0.2) {
                for (axis, part) in normal.to_array().into_iter().enumerate() {
                    values[((patch % 2) as usize * 3 + axis) * texels + t] += (scale * part) as f32;
                }
            }
        }
        Response { values }
    };
    (0..count).map(response).collect()
}

/// Returns the largest and the RMS difference of the part of G along the texels' directions, summed
/// over both classes.
fn difference(a: &[Response], b: &[Response], n: usize) -> [f64; 2] {
    let centres = texel_centres(n);
    let (mut largest, mut sum) = (0.0_f64, 0.0);
    for (a, b) in a.iter().zip(b) {
        for ((a, b), s) in a.vectors().iter().zip(b.vectors()).zip(&centres) {
            let along = |v: [f32; 3]| DVec3::from(v.map(f64::from)).dot(*s);
            let off = (along(*a) - along(b)).abs();
            largest = largest.max(off);
            sum += off * off;
        }
    }
    [largest, (sum / (a.len() * n * n) as f64).sqrt()]
}

/// At 8, 16 and 32 texels a side, responses come back within 0.41 / sqrt(4/9) steps RMS along the
/// directions and 4 steps at most. Responses of 0 come back as exactly 0. Unpacked responses pack
/// to the same bytes, and come back also in another order and among fewer receivers.
#[test]
fn responses_come_back_within_their_steps() {
    for n in [8, 16, 32] {
        let tile = tile(20, n, 0.02);
        let raw = pack(&tile).expect("bytes");
        let back = unpack(&raw, 20, n).expect("responses");
        let step = 0.5_f64.powi(i32::from(exponent(n)));
        let [largest, rms] = difference(&tile, &back, n);
        assert!(rms < 0.41 * 1.5 * step && largest < 4.0 * step, "{n}: {rms} {largest}");
        assert!(back.iter().step_by(3).all(|r| r.values.iter().all(|v| *v == 0.0)));
        assert!(pack(&back).expect("bytes") == raw, "{n}");
        let turned: Vec<Response> = back.iter().rev().take(7).cloned().collect();
        assert!(unpack(&pack(&turned).expect("bytes"), 7, n).expect("responses") == turned, "{n}");
    }
}

/// Values of 100 and of 1e-7 come back within 1e-3 of the largest and within a step. Infinities and
/// NaN become finite numbers.
#[test]
fn extreme_values_come_back_finite() {
    for scale in [100.0, 1e-7] {
        let tile = tile(3, 16, scale);
        let back = unpack(&pack(&tile).expect("bytes"), 3, 16).expect("responses");
        let [largest, _] = difference(&tile, &back, 16);
        assert!(largest < 1e-3 * scale + 2e-3, "{scale}: {largest}");
    }
    for value in [f32::INFINITY, f32::NEG_INFINITY, f32::NAN, f32::MAX] {
        let raw = pack(&[Response { values: vec![value; Response::len(8)] }]).expect("responses");
        assert!(unpack(&raw, 1, 8).expect("responses")[0].values.iter().all(|v| v.is_finite()));
    }
}

/// None of 3,000 blocks with changed or missing bytes makes the reader panic, and every block that
/// is read holds finite values. Other counts and sides, a larger exponent and more than 2^23 values
/// are refused. 12 texels a side are refused in reading and in writing.
#[test]
fn damaged_blocks_hold_finite_values() {
    let tile = tile(6, 16, 0.02);
    let raw = pack(&tile).expect("bytes");
    let mut read = 0;
    for i in 0..3_000 {
        let mut bad = raw.clone();
        let at = mix(i, 1) as usize % if i % 2 == 0 { bad.len() } else { 300 };
        bad[at] = mix(i, 2) as u8;
        bad.truncate(raw.len() - usize::from(i % 5 == 0) * (mix(i, 3) as usize % 30));
        if let Some(back) = unpack(&bad, 6, 16) {
            read += 1;
            assert!(back.iter().all(|r| r.values.iter().all(|v| v.is_finite())));
        }
    }
    assert!(read < 300, "{read}");
    assert_eq!([unpack(&raw, 5, 16), unpack(&raw, 7, 16), unpack(&raw, 6, 32)], [None, None, None]);
    assert_eq!(unpack(&[&[41], &raw[1..]].concat(), 6, 16), None);
    assert_eq!(unpack(&raw, 86, 128), None);
    assert_eq!((unpack(&raw, 6, 12), pack(&[Response { values: vec![0.0; Response::len(12)] }])), (None, None));
}
