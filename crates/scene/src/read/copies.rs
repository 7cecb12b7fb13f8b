//! Copies of linkages: entries of `[[copies]]` become bodies, links and parts of the gait.

use std::collections::{BTreeMap, HashMap};
use std::f64::consts::TAU;

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use toml::{Table, Value};

use super::deformations::default_meridian;
use super::gait::table_path;
use crate::checks::Checks;
use crate::document::Document;
use crate::domain::Domain;
use crate::error::SceneError;
use crate::gait_table::GaitTable;
use crate::keys::{CopiesFile, DEFAULT_AXIS};
use crate::nearest::Names;
use crate::shape::shape_keys;
use crate::words::DomainKind;

/// Largest number of copies of one entry.
const MAX_COPIES: u32 = 100_000;

/// Random poses that are tried for one copy. A box of which a tenth is free takes a hundred.
const MAX_ATTEMPTS: usize = 10_000;

/// Place and attitude of a copy relative to its original.
#[derive(Clone, Copy)]
struct Pose {
    /// Centre of the body that the entry names.
    position: Vector3<f64>,
    rotation: UnitQuaternion<f64>,
}

/// Replaces the entries of `[[copies]]` by the bodies, links, targets and harmonics that they stand
/// for.
///
/// # Errors
/// A body that does not exist, poses that do not fit together, copies that do not fit into the box.
pub(super) fn expand(document: &mut Document) -> Result<(), SceneError> {
    let count = list(document.values(), "copies").map_or(0, Vec::len);
    for number in 0..count {
        let place = document.place(&format!("copies[{number}]"));
        let before = list(document.values(), "bodies").map_or(0, Vec::len);
        let expanded = Expansion::new(document, number)?.expanded()?;
        document.replace_values(expanded);
        let after = list(document.values(), "bodies").map_or(0, Vec::len);
        for body in before..after {
            document.set_place(format!("bodies[{body}]"), place.clone());
        }
    }
    if count > 0 {
        document.remove("copies");
    }
    Ok(())
}

fn list<'v>(values: &'v Value, name: &str) -> Option<&'v Vec<Value>> {
    values.get(name).and_then(Value::as_array)
}

fn text<'v>(value: &'v Value, key: &str) -> Option<&'v str> {
    value.get(key).and_then(Value::as_str)
}

fn vector(value: Option<&Value>) -> Option<Vector3<f64>> {
    let number = |value: &Value| match value {
        Value::Integer(i) => Some(*i as f64),
        value => value.as_float(),
    };
    let numbers: Option<Vec<f64>> = value?.as_array()?.iter().map(number).collect();
    Some(Vector3::from_iterator(numbers.filter(|v| v.len() == 3)?))
}

fn value_of(v: &Vector3<f64>) -> Value {
    Value::Array(v.iter().map(|x| Value::Float(*x)).collect())
}

/// One entry and the linkage that it copies.
struct Expansion<'a> {
    checks: Checks<'a>,
    number: usize,
    entry: CopiesFile,
    /// The body that the entry names, and its centre.
    origin: Vector3<f64>,
    /// Bodies of the linkage, by their places in the list.
    members: Vec<usize>,
    /// Links of the linkage, by their places in the list.
    links: Vec<usize>,
}

impl<'a> Expansion<'a> {
    fn new(document: &'a Document, number: usize) -> Result<Self, SceneError> {
        let checks = Checks(document);
        let key = |key: &str| format!("copies[{number}].{key}");
        let values = document.values();
        let entry = list(values, "copies").and_then(|entries| entries.get(number));
        let entry = entry.cloned().unwrap_or(Value::Table(Table::new()));
        let entry: CopiesFile =
            entry
                .try_into()
                .map_err(|error: toml::de::Error| SceneError::Syntax {
                    place: document.place(&format!("copies[{number}]")),
                    message: error.message().to_owned(),
                })?;
        let of = checks.required(&key("of"), entry.of.clone(), ": name a body to copy")?;
        let empty = Vec::new();
        let bodies = list(values, "bodies").unwrap_or(&empty);
        let names = bodies.iter().map(|body| text(body, "name").unwrap_or(""));
        let first = checks.find(&key("of"), &of, &Names::new("body", names))?;
        let links = list(values, "links").unwrap_or(&empty);
        let (members, links) = linkage(bodies, links, first);
        for &body in &members {
            if vector(bodies[body].get("position")).is_none() {
                let problem =
                    "names a linkage with a body without position, which no copy can have";
                return Err(checks.bad_value(&key("of"), problem));
            }
        }
        let file = values.get("gait").and_then(|gait| text(gait, "file"));
        let columns = file.and_then(|file| GaitTable::columns(&table_path(&checks, file)));
        let is_driven = |&body: &usize| {
            let name = text(&bodies[body], "name").unwrap_or("");
            let mut columns = columns.iter().flatten();
            columns.any(|column| {
                let rest = column.strip_prefix(name);
                rest.is_some_and(|rest| rest.starts_with('.'))
            })
        };
        if file.is_some() && (!links.is_empty() || members.iter().any(is_driven)) {
            let problem = "copies links or bodies, which the table of gait.file does not have; \
                           write the gait as phases or harmonics";
            return Err(checks.bad_value(&key("of"), problem));
        }
        Ok(Self {
            origin: vector(bodies[first].get("position")).unwrap_or_default(),
            checks,
            number,
            entry,
            members,
            links,
        })
    }

    fn key(&self, key: &str) -> String {
        format!("copies[{}].{key}", self.number)
    }

    fn values(&self) -> &'a Value {
        self.checks.0.values()
    }

    fn body(&self, number: usize) -> Option<&'a Value> {
        list(self.values(), "bodies")?.get(number)
    }

    /// The values with all copies.
    fn expanded(&self) -> Result<Value, SceneError> {
        let poses = self.poses()?;
        let mut values = self.values().clone();
        let Value::Table(root) = &mut values else {
            return Ok(values);
        };
        let originals: Vec<Value> = (self.members.iter())
            .filter_map(|&body| self.body(body).cloned())
            .collect();
        let links = list(self.values(), "links");
        let original_links: Vec<Value> = (self.links.iter())
            .filter_map(|&link| links?.get(link).cloned())
            .collect();
        for (copy, pose) in poses.iter().enumerate() {
            let suffix = format!("-{}", copy + 2);
            let bodies = originals
                .iter()
                .map(|body| self.moved_body(body, pose, &suffix));
            append(root, "bodies", bodies.collect());
            let links = original_links
                .iter()
                .map(|link| self.moved_link(link, pose, &suffix));
            append(root, "links", links.collect());
        }
        let [links, bodies] = [&original_links, &originals].map(|list| {
            list.iter()
                .filter_map(|entry| text(entry, "name"))
                .collect()
        });
        if let Some(Value::Table(gait)) = root.get_mut("gait") {
            copy_gait(gait, &Coordinates { links, bodies }, poses.len());
        }
        Ok(values)
    }

    /// Poses of all copies: those that are given, or random ones.
    fn poses(&self) -> Result<Vec<Pose>, SceneError> {
        let entry = &self.entry;
        let Some(positions) = &entry.positions else {
            return self.random_poses();
        };
        let default = CopiesFile::default();
        let random = [
            ("count", entry.count.is_some()),
            ("size", entry.size.is_some()),
            ("centre", entry.centre != default.centre),
            ("isotropic", entry.isotropic),
            ("gap", entry.gap != default.gap),
            ("seed", entry.seed != default.seed),
        ];
        if let Some((name, _)) = random.iter().find(|(_, differs)| *differs) {
            let problem = "belongs to copies at random places; remove it or `positions`";
            return Err(self.checks.bad_value(&self.key(name), problem));
        }
        let orientations = entry.orientations.clone().unwrap_or_default();
        if !orientations.is_empty() && orientations.len() != positions.len() {
            let problem = format!(
                "has {} entries; `positions` has {}",
                orientations.len(),
                positions.len()
            );
            return Err(self.checks.bad_value(&self.key("orientations"), problem));
        }
        let rotations = orientations.iter().map(|turn| Some(Vector3::from(*turn)));
        let rotations = rotations.chain(std::iter::repeat(None));
        let poses = positions.iter().zip(rotations).map(|(x, turn)| Pose {
            position: (*x).into(),
            rotation: UnitQuaternion::from_scaled_axis(turn.unwrap_or_default()),
        });
        Ok(poses.collect())
    }

    /// Random poses in the box with gaps to all bodies, by rejection.
    fn random_poses(&self) -> Result<Vec<Pose>, SceneError> {
        let (checks, entry) = (&self.checks, &self.entry);
        if entry.orientations.is_some() {
            let problem = "belongs to copies at given `positions`; use isotropic = true";
            return Err(checks.bad_value(&self.key("orientations"), problem));
        }
        let why = ": give it with `size`, or `positions`";
        let count = checks.required(&self.key("count"), entry.count, why)?;
        if count > MAX_COPIES {
            let problem = format!("must be at most {MAX_COPIES}, not {count}");
            return Err(checks.bad_value(&self.key("count"), problem));
        }
        let size = checks.required(&self.key("size"), entry.size, ": the edges of the box")?;
        let (size, centre) = (Vector3::from(size), Vector3::from(entry.centre));
        let radius = |body: &Value| {
            let number = body.get("radius").cloned().unwrap_or(Value::Float(1.0));
            match text(body, "shape") {
                None | Some("sphere") => match number {
                    Value::Integer(i) => Some(i as f64),
                    number => number.as_float(),
                },
                Some("point") => Some(0.0),
                Some(_) => None,
            }
        };
        let all = list(self.values(), "bodies").map_or(&[][..], Vec::as_slice);
        let spheres = all.iter().map(|body| {
            let centre = vector(body.get("position"))?;
            Some((centre, radius(body)?))
        });
        let spheres: Option<Vec<(Vector3<f64>, f64)>> = spheres.collect();
        let Some(spheres) = spheres else {
            let problem = "needs a scene of spheres for random places; give `positions`";
            return Err(checks.bad_value(&self.key("count"), problem));
        };
        let own: Vec<(Vector3<f64>, f64)> = (self.members.iter())
            .map(|&body| (spheres[body].0 - self.origin, spheres[body].1))
            .collect();
        let domain = self.values().get("domain");
        let size_of_box = domain
            .filter(|domain| text(domain, "kind") == Some(DomainKind::Periodic.word()))
            .and_then(|domain| vector(domain.get("size")))
            .filter(|size| size.min() > 0.0);
        let domain = size_of_box.map_or(Domain::Unbounded, |size| Domain::Periodic { size });
        let mut room = Room::new(entry.gap, &spheres, domain);
        let mut random = fastrand::Rng::with_seed(u64::from(entry.seed));
        let mut poses = Vec::with_capacity(count as usize);
        for copy in 0..count {
            let pose = (0..MAX_ATTEMPTS).find_map(|_| {
                let mut uniform = || random.f64();
                let place = Vector3::from_fn(|_, _| uniform() - 0.5);
                let rotation = match entry.isotropic {
                    true => random_rotation([uniform(), uniform(), uniform()]),
                    false => UnitQuaternion::identity(),
                };
                let position = centre + size.component_mul(&place);
                let moved: Vec<(Vector3<f64>, f64)> = (own.iter())
                    .map(|(arm, radius)| (position + rotation * arm, *radius))
                    .collect();
                // Copies that are not turned have the images of their original.
                let is_apart = !entry.isotropic || room.is_clear_of_own_images(&moved);
                (is_apart && room.take(&moved)).then_some(Pose { position, rotation })
            });
            let Some(pose) = pose else {
                let problem = format!(
                    "cannot be {count}: after {copy} copies, none of {MAX_ATTEMPTS} random poses \
                     leaves gaps of {}; enlarge `size`, or reduce `count` or `gap`",
                    entry.gap
                );
                return Err(checks.bad_value(&self.key("count"), problem));
            };
            poses.push(pose);
        }
        Ok(poses)
    }

    fn moved_point(&self, x: &Vector3<f64>, pose: &Pose) -> Vector3<f64> {
        pose.position + pose.rotation * (x - self.origin)
    }

    /// A copy of a body. Its axes and its magnetic moment turn with it, forces and torques do not.
    fn moved_body(&self, body: &Value, pose: &Pose, suffix: &str) -> Value {
        let Value::Table(mut body) = body.clone() else {
            return body.clone();
        };
        rename(&mut body, "name", suffix);
        let position = vector(body.get("position")).unwrap_or_default();
        let moved = self.moved_point(&position, pose);
        body.insert("position".to_owned(), value_of(&moved));
        if pose.rotation == UnitQuaternion::identity() {
            return Value::Table(body);
        }
        let shape = body
            .get("shape")
            .and_then(Value::as_str)
            .unwrap_or("sphere")
            .to_owned();
        let has = |name: &str| {
            let mut all = shape_keys().into_iter();
            all.any(|(kind, keys)| kind.word() == shape && keys.contains(&name))
        };
        // A body has one of the two; an axis has a default.
        let own = vector(body.get("orientation"));
        let axis_of_body = body.get("axis").cloned();
        if own.is_none() && has("axis") {
            turn(&mut body, "axis", pose, Some(DEFAULT_AXIS.into()));
        } else if has("orientation") {
            let turned = pose.rotation * UnitQuaternion::from_scaled_axis(own.unwrap_or_default());
            body.insert("orientation".to_owned(), value_of(&turned.scaled_axis()));
        }
        turn(&mut body, "moment", pose, None);
        if let Some(Value::Table(slip)) = body.get_mut("slip") {
            turn(slip, "axis", pose, Some(DEFAULT_AXIS.into()));
        }
        if let Some(Value::Table(deformation)) = body.get_mut("deformation") {
            // Only modes have an axis; by default those of a spheroid have its own.
            let own = deformation.contains_key("modes") && !has("axis");
            if deformation.contains_key("orders") {
                let of_body = has("axis").then(|| vector(axis_of_body.as_ref())).flatten();
                let axis = vector(deformation.get("axis")).or(of_body);
                let meridian = default_meridian(&axis.unwrap_or_else(|| DEFAULT_AXIS.into()));
                turn(deformation, "meridian", pose, meridian);
            }
            turn(deformation, "axis", pose, own.then(|| DEFAULT_AXIS.into()));
        }
        Value::Table(body)
    }

    /// A copy of a link.
    fn moved_link(&self, link: &Value, pose: &Pose, suffix: &str) -> Value {
        let Value::Table(mut link) = link.clone() else {
            return link.clone();
        };
        for key in ["name", "body", "to"] {
            rename(&mut link, key, suffix);
        }
        turn(&mut link, "axis", pose, None);
        if let Some(pivot) = vector(link.get("pivot")) {
            let moved = self.moved_point(&pivot, pose);
            link.insert("pivot".to_owned(), value_of(&moved));
        }
        Value::Table(link)
    }
}

/// Turns the direction of a key, if it is given or has a default.
fn turn(table: &mut Table, key: &str, pose: &Pose, default: Option<Vector3<f64>>) {
    if let Some(direction) = vector(table.get(key)).or(default) {
        table.insert(key.to_owned(), value_of(&(pose.rotation * direction)));
    }
}

fn rename(table: &mut Table, key: &str, suffix: &str) {
    if let Some(Value::String(name)) = table.get_mut(key) {
        name.push_str(suffix);
    }
}

fn append(root: &mut Table, name: &str, more: Vec<Value>) {
    if more.is_empty() {
        return;
    }
    let slot = root.entry(name).or_insert_with(|| Value::Array(Vec::new()));
    if let Value::Array(all) = slot {
        all.extend(more);
    }
}

/// Bodies and links that are connected to a body, each in the order of the file.
fn linkage(bodies: &[Value], links: &[Value], first: usize) -> (Vec<usize>, Vec<usize>) {
    let numbers: BTreeMap<&str, usize> = (bodies.iter().enumerate())
        .filter_map(|(number, body)| Some((text(body, "name")?, number)))
        .collect();
    let ends: Vec<[Option<usize>; 2]> = (links.iter())
        .map(|link| ["body", "to"].map(|end| numbers.get(text(link, end)?).copied()))
        .collect();
    let mut is_member = vec![false; bodies.len()];
    is_member[first] = true;
    loop {
        let before = is_member.iter().filter(|member| **member).count();
        for [one, other] in ends.iter().filter_map(|[a, b]| Some([(*a)?, (*b)?])) {
            let joined = is_member[one] || is_member[other];
            (is_member[one], is_member[other]) = (joined, joined);
        }
        if is_member.iter().filter(|member| **member).count() == before {
            break;
        }
    }
    let members = (0..bodies.len()).filter(|&body| is_member[body]).collect();
    let own = (ends.iter().enumerate())
        .filter(|(_, ends)| ends.iter().flatten().any(|&body| is_member[body]))
        .map(|(link, _)| link);
    (members, own.collect())
}

/// Names of the links and bodies of a linkage.
struct Coordinates<'a> {
    links: Vec<&'a str>,
    bodies: Vec<&'a str>,
}

impl Coordinates<'_> {
    /// The name that a copy gives to a link, or to the shape coordinate `BODY.NAME`; `None` for
    /// those of other linkages.
    fn copied(&self, name: &str, suffix: &str) -> Option<String> {
        if self.links.contains(&name) {
            return Some(format!("{name}{suffix}"));
        }
        self.bodies.iter().find_map(|body| {
            let coordinate = name.strip_prefix(body)?.strip_prefix('.')?;
            Some(format!("{body}{suffix}.{coordinate}"))
        })
    }
}

/// Gives copies of links and bodies the targets and harmonics of their originals.
fn copy_gait(gait: &mut Table, own: &Coordinates, copies: usize) {
    let suffixes = || (2..copies + 2).map(|copy| format!("-{copy}"));
    if let Some(Value::Array(phases)) = gait.get_mut("phases") {
        for phase in phases.iter_mut().filter_map(Value::as_table_mut) {
            let link = phase.get("link").and_then(Value::as_str).map(str::to_owned);
            if let Some(link) = link.filter(|link| own.copied(link, "").is_some())
                && let Some(length) = phase.remove("length")
            {
                phase.remove("link");
                let targets = Table::from_iter([(link, length)]);
                phase.insert("targets".to_owned(), Value::Table(targets));
            }
            if let Some(Value::Table(targets)) = phase.get_mut("targets") {
                let copied: Vec<(String, Value)> = (targets.iter())
                    .flat_map(|(name, value)| {
                        let copied = suffixes().filter_map(|suffix| own.copied(name, &suffix));
                        copied.map(|name| (name, value.clone()))
                    })
                    .collect();
                targets.extend(copied);
            }
        }
    }
    if let Some(Value::Array(harmonics)) = gait.get_mut("harmonics") {
        let originals = harmonics.clone();
        for suffix in suffixes() {
            harmonics.extend(originals.iter().filter_map(|term| {
                let copied = own.copied(text(term, "link")?, &suffix)?;
                let mut term = term.as_table()?.clone();
                term.insert("link".to_owned(), Value::String(copied));
                Some(Value::Table(term))
            }));
        }
    }
}

/// A random rotation, all of them alike (Shoemake 1992), from three numbers between 0 and 1.
fn random_rotation([a, b, c]: [f64; 3]) -> UnitQuaternion<f64> {
    let (one, other) = ((1.0 - a).sqrt(), a.sqrt());
    let ((s, t), (u, v)) = ((TAU * b).sin_cos(), (TAU * c).sin_cos());
    UnitQuaternion::from_quaternion(Quaternion::new(other * v, one * s, one * t, other * u))
}

/// Spheres on a grid, to find those that are too close to another one; in a periodic box with the
/// images beside it.
struct Room {
    domain: Domain,
    gap: f64,
    cell: f64,
    largest: f64,
    cells: HashMap<[i64; 3], Vec<(Vector3<f64>, f64)>>,
}

impl Room {
    fn new(gap: f64, spheres: &[(Vector3<f64>, f64)], domain: Domain) -> Self {
        let largest = spheres
            .iter()
            .fold(0.0_f64, |m, (_, radius)| m.max(*radius));
        let mut room = Self {
            domain,
            gap,
            // Points alone have no size.
            cell: (2.0 * largest + gap).max(f64::MIN_POSITIVE),
            largest,
            cells: HashMap::new(),
        };
        spheres.iter().for_each(|sphere| room.enter(*sphere));
        room
    }

    fn key(&self, x: &Vector3<f64>) -> [i64; 3] {
        (x / self.cell).map(|c| c.floor() as i64).into()
    }

    fn enter(&mut self, (x, radius): (Vector3<f64>, f64)) {
        if self.largest <= 0.0 {
            return;
        }
        let outside = |x: &Vector3<f64>| {
            let size = self.domain.period();
            size.map_or(0.0, |size| (x.abs() - 0.5 * size).max())
        };
        for shift in self.domain.shifts_near(&x) {
            let x = x - shift;
            if outside(&x) <= self.cell {
                self.cells
                    .entry(self.key(&x))
                    .or_default()
                    .push((x, radius));
            }
        }
    }

    /// Whether the spheres of a linkage leave the gap to the images of each other.
    fn is_clear_of_own_images(&self, spheres: &[(Vector3<f64>, f64)]) -> bool {
        let is_clear = |(x, radius): &(Vector3<f64>, f64), (y, other): &(Vector3<f64>, f64)| {
            let apart = x - y;
            let shifts = self.domain.shifts_near(&apart);
            let mut images = shifts.iter().filter(|shift| **shift != Vector3::zeros());
            images.all(|shift| (apart - shift).norm() >= radius + other + self.gap)
        };
        let mut numbered = spheres.iter().enumerate();
        numbered.all(|(k, one)| spheres[..k].iter().all(|other| is_clear(one, other)))
    }

    /// Enters spheres if they leave the gap to all others.
    fn take(&mut self, spheres: &[(Vector3<f64>, f64)]) -> bool {
        let is_free = |(x, radius): &(Vector3<f64>, f64)| {
            let x = self.domain.nearest_image(x);
            let [i, j, k] = self.key(&x);
            // Far from all others, numbers of cells end.
            let near = |k: i64| [-1, 0, 1].map(|step| k.saturating_add(step));
            let around = near(i)
                .into_iter()
                .flat_map(|i| near(j).map(move |j| (i, j)));
            let around = around.flat_map(|(i, j)| near(k).map(move |k| [i, j, k]));
            let mut others = around.filter_map(|key| self.cells.get(&key)).flatten();
            others.all(|(y, other)| (x - y).norm() >= radius + other + self.gap)
        };
        let fits = spheres.iter().all(is_free);
        if fits {
            spheres.iter().for_each(|sphere| self.enter(*sphere));
        }
        fits
    }
}
