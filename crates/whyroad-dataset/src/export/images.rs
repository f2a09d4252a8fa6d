//! Images of a sample as files: `images/<sample id>/<camera>_<n>.<type>`, oldest first per camera.

use super::Output;
use crate::DatasetError;
use crate::sample::Sample;

/// Writes the images of a sample and returns their paths, relative to the export.
pub(super) fn write(sample: &Sample, out: &mut Output) -> Result<Vec<String>, DatasetError> {
    let mut paths = Vec::with_capacity(sample.images.len());
    for (name, image) in names(sample).into_iter().zip(&sample.images) {
        let path = format!("images/{}/{name}", sample.sample_id);
        out.write(&path, &image.bytes)?;
        paths.push(path);
    }
    Ok(paths)
}

/// File names of the images of a sample, in their order.
pub(super) fn names(sample: &Sample) -> Vec<String> {
    let mut out: Vec<String> = Vec::with_capacity(sample.images.len());
    for (i, image) in sample.images.iter().enumerate() {
        let before = sample.images[..i].iter().filter(|other| other.camera == image.camera).count();
        // A camera's name comes from a log: only letters, digits, - and _ reach a path.
        let camera: String = image
            .camera
            .chars()
            .map(|c| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' })
            .collect();
        out.push(format!("{camera}_{before}.{}", image.format));
    }
    out
}
