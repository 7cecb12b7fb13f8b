//! Small MSH files in all their dialects.

use mesh::QuadraticTets;

/// Dialect of a test file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dialect {
    pub version4: bool,
    pub second_order: bool,
    pub bytes: Bytes,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bytes {
    Text,
    Little,
    Big,
}

impl Dialect {
    /// All dialects that the reader supports.
    pub fn all() -> Vec<Self> {
        let bytes = [Bytes::Text, Bytes::Little, Bytes::Big];
        (0..12)
            .map(|k| Self {
                version4: k / 6 == 1,
                second_order: k / 3 % 2 == 1,
                bytes: bytes[k % 3],
            })
            .collect()
    }
}

struct Sink {
    bytes: Vec<u8>,
    kind: Bytes,
}

impl Sink {
    fn text(&mut self, text: &str) {
        self.bytes.extend(text.as_bytes());
    }

    fn put(&mut self, text: String, mut little: Vec<u8>) {
        match self.kind {
            Bytes::Text => self.text(&(text + " ")),
            Bytes::Little => self.bytes.append(&mut little),
            Bytes::Big => self.bytes.extend(little.iter().rev()),
        }
    }

    fn int(&mut self, value: i32) {
        self.put(value.to_string(), value.to_le_bytes().to_vec());
    }

    fn size(&mut self, value: usize) {
        self.put(value.to_string(), (value as u64).to_le_bytes().to_vec());
    }

    fn real(&mut self, value: f64) {
        self.put(value.to_string(), value.to_le_bytes().to_vec());
    }

    fn end_line(&mut self) {
        if self.kind == Bytes::Text {
            self.text("\n");
        }
    }
}

/// Node tags with gaps, so that readers cannot use them as indices.
pub fn node_tag(index: u32) -> usize {
    7 + 3 * index as usize
}

/// A file of `mesh`; the physical group `10 + tag` has the name of the tag.
pub fn encode(mesh: &QuadraticTets, dialect: Dialect) -> Vec<u8> {
    let mut sink = Sink {
        bytes: Vec::new(),
        kind: dialect.bytes,
    };
    let version = if dialect.version4 { "4.1" } else { "2.2" };
    let file_type = u8::from(dialect.bytes != Bytes::Text);
    sink.text(&format!("$MeshFormat\n{version} {file_type} 8\n"));
    if dialect.bytes != Bytes::Text {
        sink.int(1);
        sink.text("\n");
    }
    sink.text("$EndMeshFormat\n$PhysicalNames\n");
    sink.text(&format!("{}\n", mesh.tags.len() + 1));
    for (tag, name) in mesh.tags.iter().enumerate() {
        sink.text(&format!("2 {} \"{name}\"\n", 10 + tag));
    }
    sink.text("3 1 \"fluid\"\n$EndPhysicalNames\n");
    if dialect.version4 {
        version4(&mut sink, mesh, dialect.second_order);
    } else {
        version2(&mut sink, mesh, dialect.second_order);
    }
    sink.bytes
}

/// The nodes of an element in the file, in the order of Gmsh.
fn element_nodes(tet: &[u32; 10], second_order: bool) -> Vec<u32> {
    let [a, b, c, d, ab, bc, ca, da, db, dc] = *tet;
    if second_order {
        vec![a, b, c, d, ab, bc, ca, da, dc, db]
    } else {
        vec![a, b, c, d]
    }
}

fn used_nodes(mesh: &QuadraticTets, second_order: bool) -> Vec<u32> {
    let mut nodes: Vec<u32> = mesh
        .tets
        .iter()
        .flat_map(|tet| element_nodes(tet, second_order))
        .collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

/// Type number and elements (nodes and tag) of triangles and tets.
type Block = (i32, Vec<(Vec<u32>, u16)>);

fn blocks(mesh: &QuadraticTets, second_order: bool) -> Vec<Block> {
    let (face_type, tet_type, face_nodes) = if second_order { (9, 11, 6) } else { (2, 4, 3) };
    let mut blocks: Vec<Block> = Vec::new();
    for tag in 0..mesh.tags.len() as u16 {
        let faces = mesh.faces.iter().filter(|face| face.1 == tag);
        let faces = faces
            .map(|face| (face.0[..face_nodes].to_vec(), tag))
            .collect();
        blocks.push((face_type, faces));
    }
    let tets = mesh
        .tets
        .iter()
        .map(|tet| (element_nodes(tet, second_order), 0))
        .collect();
    blocks.push((tet_type, tets));
    blocks
}

fn version2(sink: &mut Sink, mesh: &QuadraticTets, second_order: bool) {
    let nodes = used_nodes(mesh, second_order);
    sink.text(&format!("$Nodes\n{}\n", nodes.len()));
    for &node in &nodes {
        sink.int(node_tag(node) as i32);
        for x in mesh.points[node as usize].iter() {
            sink.real(*x);
        }
        sink.end_line();
    }
    // A point element, which Gmsh writes for geometric points in groups.
    let blocks = blocks(mesh, second_order);
    let count: usize = blocks.iter().map(|block| block.1.len()).sum();
    sink.text(&format!("\n$EndNodes\n$Elements\n{}\n", count + 1));
    let point = (15, vec![(vec![nodes[0]], 0)]);
    let mut element = 0;
    for (code, elements) in [point].iter().chain(&blocks) {
        if sink.kind != Bytes::Text {
            sink.int(*code);
            sink.int(elements.len() as i32);
            sink.int(2);
        }
        for (nodes, tag) in elements {
            element += 1;
            sink.int(element);
            if sink.kind == Bytes::Text {
                sink.int(*code);
                sink.int(2);
            }
            sink.int(10 + i32::from(*tag));
            sink.int(1 + i32::from(*tag));
            for &node in nodes {
                sink.int(node_tag(node) as i32);
            }
            sink.end_line();
        }
    }
    sink.text("\n$EndElements\n");
}

fn version4(sink: &mut Sink, mesh: &QuadraticTets, second_order: bool) {
    let n_tags = mesh.tags.len();
    sink.text("$Entities\n");
    for count in [1, 0, n_tags, 1] {
        sink.size(count);
    }
    sink.end_line();
    sink.int(1);
    for _ in 0..3 {
        sink.real(0.5);
    }
    sink.size(0);
    sink.end_line();
    let mut entity = |tag: i32, group: i32, bounds: &[i32]| {
        sink.int(tag);
        for x in [-1.0, -1.0, -1.0, 1.0, 1.0, 1.0] {
            sink.real(x);
        }
        sink.size(1);
        sink.int(group);
        sink.size(bounds.len());
        for &bound in bounds {
            sink.int(bound);
        }
        sink.end_line();
    };
    let surfaces: Vec<i32> = (1..=n_tags as i32).collect();
    for &surface in &surfaces {
        entity(surface, 9 + surface, &[]);
    }
    entity(1, 1, &surfaces);
    let nodes = used_nodes(mesh, second_order);
    sink.text("\n$EndEntities\n$Nodes\n");
    // Two blocks: one with parametric coordinates on a surface, one in the volume.
    let (first, second) = nodes.split_at(nodes.len() / 2);
    for size in [
        2,
        nodes.len(),
        node_tag(nodes[0]),
        node_tag(nodes[nodes.len() - 1]),
    ] {
        sink.size(size);
    }
    sink.end_line();
    for (dimension, parametric, block) in [(2, 1, first), (3, 0, second)] {
        for head in [dimension, 1, parametric] {
            sink.int(head);
        }
        sink.size(block.len());
        sink.end_line();
        for &node in block {
            sink.size(node_tag(node));
            sink.end_line();
        }
        for &node in block {
            for x in mesh.points[node as usize].iter() {
                sink.real(*x);
            }
            for _ in 0..dimension * parametric {
                sink.real(0.25);
            }
            sink.end_line();
        }
    }
    let blocks = blocks(mesh, second_order);
    let count: usize = blocks.iter().map(|block| block.1.len()).sum();
    sink.text("\n$EndNodes\n$Elements\n");
    for size in [blocks.len() + 1, count + 1, 1, count + 1] {
        sink.size(size);
    }
    sink.end_line();
    let point = (15, vec![(vec![nodes[0]], 0)]);
    let mut element = 0;
    for (i, (code, elements)) in [point].iter().chain(&blocks).enumerate() {
        // Points, then surfaces, then the volume.
        let (dimension, entity) = match i {
            0 => (0, 1),
            i if i <= n_tags => (2, i as i32),
            _ => (3, 1),
        };
        for head in [dimension, entity, *code] {
            sink.int(head);
        }
        sink.size(elements.len());
        sink.end_line();
        for (nodes, _) in elements {
            element += 1;
            sink.size(element);
            for &node in nodes {
                sink.size(node_tag(node));
            }
            sink.end_line();
        }
    }
    sink.text("\n$EndElements\n");
}
