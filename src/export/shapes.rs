//! Instances as Mitsuba's shapes.
//!
//! In: the instances of a scene and their transforms. Out: a `<shape>` for each material of each instance, and their
//! mesh files.
//!
//! - Surfaces that do not emit are in object space, with a transform. A mesh with several instances becomes a
//!   `shapegroup` with an `instance` each.
//! - Emissive surfaces and those with normal maps are in world space, since mirroring does not change the front side; and flat
//!   unless they reflect by smooth normals, since Mitsuba derives the emitting side and the projected area from the shading normal.
//! - A portal, an invisible emitter, is a `null` surface with an emitter, as are the spheres and discs of lights. `volpath` lets
//!   light pass through it, and `hide_emitters` hides it from the camera, but with it all area lights. So each visible area light
//!   gets a copy right behind it, and between the two a pane of glass with index 1: behind the pane a camera ray counts as
//!   scattered, and sees the copy. Other rays do not reach the copy, and it is never sampled as a light.

use std::collections::BTreeMap;

use glam::{Affine3A, Vec3, Vec4};

use super::exporter::{Content, Export, Owner, Part, named};
use super::ply::PlyMesh;
use super::remarks;
use super::xml::Element;
use crate::scene::{Alpha, Material, Mesh, SurfaceTransform};

/// Distance of pane and copy, relative to 1 + |p|. Must exceed Mitsuba's ray offset of 9e-5 * (1 + |p|).
const BEHIND: f32 = 2e-4;

impl Part {
    /// The mesh of the file.
    pub(super) fn mesh(&self, export: &Export<'_>) -> PlyMesh {
        let scene = export.scene;
        let material = &scene.materials[self.material as usize];
        let textured = material.textures().next().is_some() || material.alpha_mask.is_some();
        let details = Details { material, is_coloured: export.coloured.contains(&self.material) };
        let mut part = match self.owner {
            Owner::Mesh(mesh) => in_object_space(&scene.meshes[mesh], self.material, &details),
            Owner::Instance { index, steps, .. } => {
                let mesh = &scene.meshes[scene.instances[index].mesh];
                in_world_space(mesh, self.material, (&export.pose.instances[index], steps), &details)
            }
        };
        if matches!(self.owner, Owner::Instance { smooth: false, .. }) {
            part.normals.clear();
        }
        if !textured {
            part.uvs.clear();
        }
        part
    }
}

impl Export<'_> {
    /// The shapes of all instances.
    pub(super) fn shapes(&mut self) -> Vec<Element> {
        let scene = self.scene;
        let materials: Vec<_> = scene.meshes.iter().map(|mesh| materials_of(mesh)).collect();
        let mut copies = vec![0; scene.meshes.len()];
        for instance in scene.instances.iter().filter(|instance| instance.visible) {
            copies[instance.mesh] += 1;
        }
        let mut shapes = Vec::new();
        for (index, instance) in scene.instances.iter().enumerate() {
            let emits = |material: u32| scene.materials[material as usize].is_emissive();
            let has_normal_map = |material: u32| scene.materials[material as usize].normal_texture.is_some();
            let mut surfaces = Vec::new();
            for (&material, triangles) in &materials[instance.mesh] {
                match (instance.visible, emits(material)) {
                    (true, false) if has_normal_map(material) => shapes.push(self.mapped(index, material)),
                    (true, false) => surfaces.push(material),
                    (true, true) => shapes.extend(self.emissive(index, material)),
                    (false, true) => shapes.push(self.portal(index, material)),
                    (false, false) => continue,
                }
                self.triangles += triangles;
            }
            if copies[instance.mesh] > 1 && !surfaces.is_empty() {
                shapes.extend(self.group(instance.mesh, &surfaces));
                shapes.push(self.group_instance(index));
            } else {
                let transform = &self.pose.instances[index];
                let parts = surfaces.iter().map(|&material| self.surface(instance.mesh, material));
                shapes.extend(parts.map(|part| part.placed(transform)));
            }
        }
        shapes
    }

    /// The shape group of a mesh's surfaces, unless it exists already.
    fn group(&mut self, mesh: usize, surfaces: &[u32]) -> Option<Element> {
        let is_new = self.groups.insert(mesh);
        is_new.then(|| {
            let parts: Vec<_> = surfaces.iter().map(|&material| self.surface(mesh, material)).collect();
            Element::plugin("shape", "shapegroup").attribute("id", self.mesh_id(mesh)).children(parts)
        })
    }

    /// An instance of its mesh's shape group.
    fn group_instance(&mut self, index: usize) -> Element {
        self.shapes += 1;
        let instance = &self.scene.instances[index];
        let group = Element::new("ref").attribute("id", self.mesh_id(instance.mesh));
        let copy =
            Element::plugin("shape", "instance").attribute("id", named("instance", index, &instance.name));
        copy.child(group).placed(&self.pose.instances[index])
    }

    fn mesh_id(&self, mesh: usize) -> String {
        named("mesh", mesh, &self.scene.meshes[mesh].name)
    }

    /// A part of a mesh that does not emit.
    fn surface(&mut self, mesh: usize, material: u32) -> Element {
        let flips = !self.remarks.contains(remarks::FLIPPED_NORMALS) && !self.is_special(material);
        if flips && has_smooth(&self.scene.meshes[mesh], material) {
            self.remarks.insert(remarks::FLIPPED_NORMALS);
        }
        let shape = self.shape(Part { owner: Owner::Mesh(mesh), material });
        self.with_bsdf(shape, material)
    }

    /// A shape with a normal map, in world space, as its tangents are.
    fn mapped(&mut self, index: usize, material: u32) -> Element {
        let owner = Owner::Instance { index, steps: 0, smooth: true };
        let shape = self.world_shape(Part { owner, material });
        self.with_bsdf(shape, material)
    }

    /// An emissive shape and, if `hide_emitters` hides it, pane and copy for the camera.
    fn emissive(&mut self, index: usize, material: u32) -> Vec<Element> {
        let smooth = self.keeps_normals(index, material);
        let shape = self.world_shape(Part { owner: Owner::Instance { index, steps: 0, smooth }, material });
        let mut shapes = vec![self.with_bsdf(shape, material).child(self.emitter(material))];
        if self.hides_emitters {
            let pane = Element::plugin("bsdf", "dielectric").float("int_ior", 1.0).float("ext_ior", 1.0);
            shapes.push(self.flat_shape(index, material, 1).child(pane));
            let copy = self.flat_shape(index, material, 2);
            let emitter = self.emitter(material).float("sampling_weight", 0.0);
            shapes.push(self.with_bsdf(copy, material).child(emitter));
        }
        shapes
    }

    /// An emissive shape that rays pass through.
    fn portal(&mut self, index: usize, material: u32) -> Element {
        let shape = self.flat_shape(index, material, 0);
        shape.child(Element::plugin("bsdf", "null")).child(self.emitter(material))
    }

    fn emitter(&mut self, material: u32) -> Element {
        let emitter = Element::plugin("emitter", "area");
        self.radiance(emitter, &self.scene.materials[material as usize])
    }

    fn with_bsdf(&mut self, shape: Element, material: u32) -> Element {
        self.used_materials.insert(material);
        self.remark_textures(material);
        shape.child(Element::new("ref").attribute("id", self.bsdf_id(material)))
    }

    /// Adds remarks on how textures are read.
    fn remark_textures(&mut self, material: u32) {
        let surface = &self.scene.materials[material as usize];
        let mut places = surface.textures().map(|image| (image.set, image.matrix, image.offset));
        let first = places.next();
        if places.any(|place| Some(place) != first) {
            self.remarks.insert(remarks::COORDINATES);
        }
        if surface.alpha == Alpha::Blend && self.coloured.contains(&material) {
            self.remarks.insert(remarks::VERTEX_ALPHA);
        }
    }

    fn flat_shape(&mut self, index: usize, material: u32, steps: u32) -> Element {
        self.world_shape(Part { owner: Owner::Instance { index, steps, smooth: false }, material })
    }

    fn world_shape(&mut self, part: Part) -> Element {
        let is_flat = matches!(part.owner, Owner::Instance { smooth: false, .. });
        let shape = self.shape(part);
        if is_flat { shape.boolean("face_normals", true) } else { shape }
    }

    /// A shape without a material.
    fn shape(&mut self, part: Part) -> Element {
        let material = self.bsdf_id(part.material);
        let id = match part.owner {
            Owner::Mesh(mesh) => format!("{}-{material}", self.mesh_id(mesh)),
            Owner::Instance { index, steps, .. } => {
                let instance = named("instance", index, &self.scene.instances[index].name);
                format!("{instance}-{material}{}", ["", "-pane", "-copy"][steps as usize])
            }
        };
        self.shapes += 1;
        let file = format!("meshes/{id}.ply");
        self.add_file(&file, Content::Mesh(part));
        Element::plugin("shape", "ply").attribute("id", id).string("filename", &file)
    }

    /// Whether an emissive surface keeps its smooth normals: if it reflects by them; adds the remarks on that.
    fn keeps_normals(&mut self, index: usize, material: u32) -> bool {
        let scene = self.scene;
        let glow = &scene.materials[material as usize];
        let mesh = &scene.meshes[scene.instances[index].mesh];
        let reflects = glow.base_colour != Vec3::ZERO || glow.mean_bsdf(scene).reflects();
        let has_normals = glow.normal_texture.is_some() || has_smooth(mesh, material);
        let smooth = reflects && !self.hides_emitters && has_normals;
        if reflects && self.hides_emitters {
            self.remarks.insert(remarks::EMITTERS_WITHOUT_REFLECTION);
        } else if smooth {
            self.remarks.insert(remarks::SMOOTH_EMITTERS);
        }
        let varies = glow.alpha == Alpha::Blend && glow.base_colour_texture.is_some();
        if glow.alpha_mask.is_some() || varies {
            self.remarks.insert(remarks::MASKED_EMISSION);
        }
        if glow.emits_on_both_sides {
            self.remarks.insert(remarks::ONE_SIDED_EMISSION);
        }
        smooth
    }
}

/// Triangle count by material of a mesh.
fn materials_of(mesh: &Mesh) -> BTreeMap<u32, usize> {
    let mut materials = BTreeMap::new();
    for &material in &mesh.triangle_materials {
        *materials.entry(material).or_insert(0) += 1;
    }
    materials
}

/// Indices of the triangles of a material.
fn triangles_of(mesh: &Mesh, material: u32) -> impl Iterator<Item = usize> {
    let of = mesh.triangle_materials.iter().enumerate();
    of.filter(move |&(_, &other)| other == material).map(|(triangle, _)| triangle)
}

/// Whether a triangle of a material has smooth shading normals.
fn has_smooth(mesh: &Mesh, material: u32) -> bool {
    triangles_of(mesh, material).any(|triangle| {
        let flat = normal_of(mesh.triangle_positions(triangle as u32));
        mesh.triangles[triangle].iter().any(|&vertex| mesh.normals[vertex as usize].dot(flat).abs() < 0.999)
    })
}

/// The vertex data that a material needs besides positions and normals.
struct Details<'a> {
    material: &'a Material,
    is_coloured: bool,
}

impl Details<'_> {
    /// Adds the data of a vertex. `turned` transforms a tangent.
    fn add(&self, mesh: &Mesh, vertex: usize, part: &mut PlyMesh, turned: impl Fn(Vec4) -> Vec4) {
        let first = mesh.uvs[vertex];
        let uvs = [first, mesh.second_uvs.get(vertex).copied().unwrap_or(first)];
        // All textures of a material have the coordinates of its first one.
        part.uvs.push(self.material.textures().next().map_or(first, |image| image.coordinates(uvs)));
        if self.is_coloured {
            let colour = mesh.colours.get(vertex).map_or(Vec3::ONE, |colour| colour.truncate());
            part.colours.push(colour);
        }
        if self.material.normal_texture.is_some() {
            part.tangents.push(turned(mesh.tangents.get(vertex).copied().unwrap_or(Vec4::ZERO)));
        }
    }
}

/// The triangles of a material with their vertices, in object space.
fn in_object_space(mesh: &Mesh, material: u32, details: &Details<'_>) -> PlyMesh {
    const UNUSED: u32 = u32::MAX;
    let mut places = vec![UNUSED; mesh.positions.len()];
    let mut part = PlyMesh::default();
    for triangle in triangles_of(mesh, material) {
        let corners = mesh.triangles[triangle].map(|vertex| {
            let vertex = vertex as usize;
            if places[vertex] == UNUSED {
                places[vertex] = part.positions.len() as u32;
                part.positions.push(mesh.positions[vertex]);
                part.normals.push(mesh.normals[vertex]);
                details.add(mesh, vertex, &mut part, |tangent| tangent);
            }
            places[vertex]
        });
        part.triangles.push(corners);
    }
    part
}

/// The triangles of a material in world space, offset by `steps` away from the emitting side.
fn in_world_space(
    mesh: &Mesh,
    material: u32,
    (transform, steps): (&Affine3A, u32),
    details: &Details<'_>,
) -> PlyMesh {
    let mirrored = transform.matrix3.determinant() < 0.0;
    let side = if mirrored { -1.0 } else { 1.0 };
    let turned = |tangent: Vec4| transform.transform_vector3(tangent.truncate()).extend(side * tangent.w);
    let placement = SurfaceTransform::new(transform);
    let mut part = PlyMesh::default();
    for triangle in triangles_of(mesh, material) {
        let mut vertices = mesh.triangles[triangle];
        if mirrored {
            vertices.swap(1, 2);
        }
        let first = part.positions.len() as u32;
        part.triangles.push([first, first + 1, first + 2]);
        part.positions
            .extend(vertices.map(|vertex| transform.transform_point3(mesh.positions[vertex as usize])));
        part.normals.extend(vertices.map(|vertex| placement.normal(mesh.normals[vertex as usize])));
        vertices.iter().for_each(|&vertex| details.add(mesh, vertex as usize, &mut part, turned));
    }
    let reach = part.positions.iter().fold(0.0f32, |reach, point| reach.max(point.abs().max_element()));
    let distance = steps as f32 * BEHIND * (1.0 + reach);
    for corners in part.positions.as_chunks_mut().0 {
        let shift = normal_of(*corners) * distance;
        corners.iter_mut().for_each(|corner| *corner -= shift);
    }
    part
}

/// Unit normal on the counter-clockwise side; zero for collinear corners.
fn normal_of([a, b, c]: [Vec3; 3]) -> Vec3 {
    (b - a).cross(c - a).normalize_or_zero()
}
