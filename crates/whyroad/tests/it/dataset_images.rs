//! Camera images from files beside a log to a trainer's files: `media add`, a build with `images: cameras`, exports.
//! Each image carries its number in its pixels, so that a sample shows which moment it has.
#![allow(clippy::unwrap_used)] // in a test a panic is the report

use crate::media::copy_folder;
use crate::service::demo;
use crate::session::whyroad_in;
use serde_json::Value;
use std::path::Path;
use whyroad_dataset::Release;

/// Images of [`lake_with_images`] a second.
pub(crate) const RATE_HZ: f64 = 10.0;
const SIZE: (u32, u32) = (16, 12);

#[track_caller]
fn good(folder: &Path, line: &str, codes: &[i32]) {
    let run = whyroad_in(folder, &line.split(' ').collect::<Vec<_>>());
    assert!(codes.contains(&run.code), "{line}: {} {}{}", run.code, run.out, run.err);
}

/// A PNG file whose pixels all say `number`.
fn png(number: usize) -> Vec<u8> {
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, SIZE.0, SIZE.1);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let pixel = [(number >> 8) as u8, (number & 255) as u8, 77];
    let pixels = pixel.repeat((SIZE.0 * SIZE.1) as usize);
    encoder.write_header().unwrap().write_image_data(&pixels).unwrap();
    out
}

/// The number in a decoded image.
fn number(bytes: &[u8]) -> usize {
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    assert_eq!((info.width, info.height), SIZE);
    assert!(pixels.chunks(3).all(|p| p == &pixels[..3] && p[2] == 77));
    usize::from(pixels[0]) << 8 | usize::from(pixels[1])
}

/// A lake with numbered images of one camera along every drive, and a spec that asks for camera images.
pub(crate) fn lake_with_images(at: &Path) -> whyroad_lake::Lake {
    copy_folder(&demo().join("lake"), &at.join("lake"));
    let lake = whyroad_lake::Lake::open(at.join("lake")).unwrap();
    std::fs::create_dir(at.join("front")).unwrap();
    let lasts = |id| {
        let times = lake.read_drive(id).unwrap().times;
        (times[times.len() - 1] - times[0]).as_secs_f64()
    };
    let count = (lake.drive_ids().iter().map(lasts).fold(0.0, f64::max) * RATE_HZ) as usize + 1;
    for n in 0..count {
        std::fs::write(at.join(format!("front/{n}.png")), png(n)).unwrap();
    }
    for id in lake.drive_ids() {
        // 3: images after the end of a shorter drive are left out and named.
        good(
            at,
            &format!(
                "media add --lake lake --drive {id} --camera front_wide_120fov --pictures front --rate {RATE_HZ} --copy"
            ),
            &[0, 3],
        );
    }
    good(at, "dataset init template.yaml", &[0]);
    let spec = std::fs::read_to_string(at.join("template.yaml")).unwrap();
    std::fs::write(at.join("dataset.yaml"), spec.replace("images: none", "images: cameras")).unwrap();
    lake
}

#[test]
fn camera_images_reach_the_files_of_a_trainer() {
    let dir = tempfile::tempdir().unwrap();
    let at = dir.path();
    let lake = lake_with_images(at);
    let mined = demo().join("mined").display().to_string();
    good(
        at,
        &format!("dataset build --spec dataset.yaml --drafts --labels {mined} --lake lake --out release"),
        &[0],
    );

    let release = Release::open(at.join("release")).unwrap();
    let samples: Vec<_> = release.samples(None).map(Result::unwrap).collect();
    assert!(samples.len() >= 5, "{}", samples.len());
    for s in &samples {
        assert_eq!(s.images.iter().map(|i| i.t_s).collect::<Vec<_>>(), [-0.3, -0.2, -0.1, 0.0]);
        let start = lake.read_drive(&s.lineage.drive_id.as_str().into()).unwrap().times[0];
        let t0 = (s.lineage.keyframe_time_ns - start.0) as f64 / 1e9;
        for image in &s.images {
            assert_eq!((image.camera.as_str(), image.format.as_str()), ("front_wide_120fov", "png"));
            // The image that was taken at that moment: never a later one.
            let expected = ((t0 + f64::from(image.t_s)) * RATE_HZ + 1e-3).floor() as usize;
            assert_eq!(number(&image.bytes), expected, "{} at {}", s.sample_id, image.t_s);
        }
    }
    good(at, "dataset verify release", &[0]);

    good(at, "dataset export ms-swift release --out swift", &[0]);
    let mut seen = 0;
    for split in ["train", "val", "test"] {
        let text = std::fs::read_to_string(at.join(format!("swift/sft.{split}.jsonl"))).unwrap_or_default();
        for line in text.lines() {
            let record: Value = serde_json::from_str(line).unwrap();
            let numbers: Vec<usize> = record["images"]
                .as_array()
                .unwrap()
                .iter()
                .map(|p| number(&std::fs::read(at.join("swift").join(p.as_str().unwrap())).unwrap()))
                .collect();
            assert!(numbers.windows(2).all(|w| w[1] == w[0] + 1), "{numbers:?}");
            seen += 1;
        }
    }
    assert_eq!(seen, samples.len());
    // Three of the four cameras that the Alpamayo loader takes are missing: it would drop every clip, and the export
    // says so.
    good(at, "dataset export alpamayo release --out alpamayo", &[0]);
    let preflight: Value =
        serde_json::from_slice(&std::fs::read(at.join("alpamayo/preflight.json")).unwrap()).unwrap();
    let reasons = preflight["dropped_by_the_loader"].as_object().unwrap();
    let missing = reasons.iter().find(|(reason, _)| reason.starts_with("cameras are missing")).unwrap();
    assert!(missing.0.contains("camera_cross_left_120fov"), "{}", missing.0);
    assert_eq!(missing.1.as_array().unwrap().len() as u64, preflight["clips"].as_u64().unwrap());
}
