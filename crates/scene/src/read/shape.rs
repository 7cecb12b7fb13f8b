//! The shape of a body of a scene file.

use crate::error::SceneError;
use crate::keys::BodyFile;
use crate::shape::{Shape, shape_keys};
use crate::shapes::ShapeKeys;
use crate::words::ShapeKind;

/// The shape of a body; keys that the shape does not have are refused.
pub(super) fn shape(keys: ShapeKeys) -> Result<Shape, SceneError> {
    let kind = keys.file.shape;
    let bad = |name: &str, problem: String| Err(keys.checks.bad_value(&keys.path(name), problem));
    if kind == ShapeKind::Point && keys.file.torque.is_some() {
        let problem = "cannot act on a point, which does not rotate; remove it";
        return bad("torque", problem.to_owned());
    }
    let all = shape_keys();
    let prefix = BodyFile::TABLE.prefix;
    for name in BodyFile::TABLE
        .keys
        .iter()
        .map(|key| &key.path[prefix.len()..])
    {
        let owners: Vec<ShapeKind> = (all.iter())
            .filter(|(_, keys)| keys.contains(&name))
            .map(|(owner, _)| *owner)
            .collect();
        let is_given = keys.checks.0.has(&keys.path(name));
        if !is_given || owners.is_empty() || owners.contains(&kind) {
            continue;
        }
        let problem = match kind {
            ShapeKind::Point => "makes no sense for a point; remove it".to_owned(),
            _ => {
                let words: Vec<_> = owners.iter().map(|s| format!("\"{}\"", s.word())).collect();
                let words = words.join(", ");
                format!("belongs to shape = {words}; remove it or set the shape")
            }
        };
        return bad(name, problem);
    }
    Shape::read(keys)
}
