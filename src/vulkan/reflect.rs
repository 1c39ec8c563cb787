//! SPIR-V reflection: bindings by name, push constants, group size, struct layouts.

use std::collections::{BTreeMap, BTreeSet};

use rspirv::dr::{Instruction, Module, Operand};
use rspirv::spirv::{Decoration, Dim, ExecutionMode, Op, StorageClass, Word};

use super::VulkanError;

/// Descriptor type of a binding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BindingKind {
    /// `uniform` block.
    UniformBuffer,
    /// `buffer` block that the shader may write.
    StorageBuffer,
    /// `readonly buffer` block.
    ReadOnlyStorageBuffer,
    /// `utextureBuffer`.
    TexelBuffer,
    /// `texture2D`, `texture2DArray`.
    SampledImage,
    /// `image2D`, `image2DArray`.
    StorageImage,
    /// `sampler2D`: image with sampler.
    CombinedImageSampler,
    /// `accelerationStructureEXT`.
    AccelerationStructure,
}

/// One binding of a shader.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Binding {
    /// Descriptor set.
    pub set: u32,
    /// Binding number within the set.
    pub binding: u32,
    /// Descriptor type.
    pub kind: BindingKind,
    /// Whether a function that the entry point calls, directly or not, names it.
    pub used: bool,
}

/// Interface of one shader, or of all stages of a pipeline.
#[derive(Clone, Debug, Default)]
pub struct Reflection {
    /// Bindings by name.
    pub bindings: BTreeMap<String, Binding>,
    /// Bytes of push constants.
    pub push_size: u32,
    /// Group size of a compute shader, zero otherwise.
    pub group_size: [u32; 3],
    /// Offset of each member of each struct, by struct name.
    pub structs: BTreeMap<String, Vec<(String, u32)>>,
    /// Stride of each runtime or fixed array of structs, by struct name.
    pub strides: BTreeMap<String, u32>,
}

impl Reflection {
    /// Reflects a SPIR-V module. `name` is for messages.
    pub fn new(name: &str, spirv: &[u8]) -> Result<Self, VulkanError> {
        let module = rspirv::dr::load_bytes(spirv)
            .map_err(|error| VulkanError::Shader { name: name.to_owned(), problem: error.to_string() })?;
        Ok(Reader::new(&module).read())
    }

    /// Merges the stages of a graphics pipeline.
    pub(super) fn merge(mut self, other: Self) -> Self {
        for (name, binding) in other.bindings {
            let used = self.bindings.get(&name).is_some_and(|binding| binding.used) || binding.used;
            self.bindings.insert(name, Binding { used, ..binding });
        }
        self.push_size = self.push_size.max(other.push_size);
        self.structs.extend(other.structs);
        self.strides.extend(other.strides);
        self
    }
}

struct Reader<'a> {
    module: &'a Module,
    names: BTreeMap<Word, &'a str>,
    member_names: BTreeMap<(Word, u32), &'a str>,
    types: BTreeMap<Word, &'a Instruction>,
}

impl<'a> Reader<'a> {
    fn new(module: &'a Module) -> Self {
        let mut names = BTreeMap::new();
        let mut member_names = BTreeMap::new();
        for name in &module.debug_names {
            match (name.class.opcode, name.operands.as_slice()) {
                (Op::Name, [Operand::IdRef(id), Operand::LiteralString(text)]) => {
                    names.insert(*id, text.as_str());
                }
                (
                    Op::MemberName,
                    [Operand::IdRef(id), Operand::LiteralBit32(member), Operand::LiteralString(text)],
                ) => {
                    member_names.insert((*id, *member), text.as_str());
                }
                _ => {}
            }
        }
        let types = module
            .types_global_values
            .iter()
            .filter_map(|instruction| Some((instruction.result_id?, instruction)))
            .collect();
        Self { module, names, member_names, types }
    }

    fn read(&self) -> Reflection {
        let mut reflection = Reflection { group_size: self.group_size(), ..Reflection::default() };
        let used = self.statically_used();
        for variable in &self.module.types_global_values {
            if variable.class.opcode != Op::Variable {
                continue;
            }
            self.read_variable(variable, &used, &mut reflection);
        }
        for (&id, instruction) in &self.types {
            match instruction.class.opcode {
                // Skip structs of local variables: they have no offsets, and may share a buffer struct's name.
                Op::TypeStruct if self.member_decoration(id, 0, Decoration::Offset).is_some() => {
                    let name = self.names.get(&id).copied().unwrap_or_default().to_owned();
                    reflection.structs.insert(name, self.members(id, instruction));
                }
                Op::TypeRuntimeArray | Op::TypeArray => {
                    let element = id_at(instruction, 0);
                    if let (Some(stride), Some(name)) =
                        (self.decoration(id, Decoration::ArrayStride), self.names.get(&element))
                    {
                        reflection.strides.insert((*name).to_owned(), stride);
                    }
                }
                _ => {}
            }
        }
        reflection
    }

    fn read_variable(&self, variable: &Instruction, used: &BTreeSet<Word>, reflection: &mut Reflection) {
        let Some(id) = variable.result_id else { return };
        let Some(pointer) = variable.result_type.and_then(|id| self.types.get(&id)) else { return };
        let pointee = id_at(pointer, 1);
        let class = match variable.operands.first() {
            Some(Operand::StorageClass(class)) => *class,
            _ => return,
        };
        if class == StorageClass::PushConstant {
            reflection.push_size = self.size_of(pointee);
            return;
        }
        let Some(kind) = self.kind_of(class, pointee) else { return };
        let name = [id, pointee]
            .iter()
            .find_map(|id| self.names.get(id).filter(|name| !name.is_empty()))
            .map_or_else(String::new, |name| (*name).to_owned());
        let binding = Binding {
            set: self.decoration(id, Decoration::DescriptorSet).unwrap_or(0),
            binding: self.decoration(id, Decoration::Binding).unwrap_or(0),
            kind,
            used: used.contains(&id),
        };
        reflection.bindings.insert(name, binding);
    }

    /// Every id in the functions that the entry point reaches: static use in Vulkan's terms.
    fn statically_used(&self) -> BTreeSet<Word> {
        let mut used = BTreeSet::new();
        let mut next: Vec<Word> = self.module.entry_points.iter().map(|point| id_at(point, 1)).collect();
        let mut reached = BTreeSet::new();
        while let Some(id) = next.pop() {
            if !reached.insert(id) {
                continue;
            }
            let functions = self.module.functions.iter();
            for function in functions.filter(|function| function.def_id() == Some(id)) {
                for instruction in function.all_inst_iter() {
                    let ids = instruction.operands.iter().filter_map(Operand::id_ref_any);
                    used.extend(ids);
                    if instruction.class.opcode == Op::FunctionCall {
                        next.push(id_at(instruction, 0));
                    }
                }
            }
        }
        used
    }

    fn kind_of(&self, class: StorageClass, pointee: Word) -> Option<BindingKind> {
        match class {
            StorageClass::Uniform => Some(BindingKind::UniformBuffer),
            StorageClass::StorageBuffer if self.all_read_only(pointee) => {
                Some(BindingKind::ReadOnlyStorageBuffer)
            }
            StorageClass::StorageBuffer => Some(BindingKind::StorageBuffer),
            StorageClass::UniformConstant => {
                let instruction = self.types.get(&pointee)?;
                if instruction.operands.get(1) == Some(&Operand::Dim(Dim::DimBuffer)) {
                    return Some(BindingKind::TexelBuffer);
                }
                match (instruction.class.opcode, instruction.operands.get(5)) {
                    (Op::TypeAccelerationStructureKHR, _) => Some(BindingKind::AccelerationStructure),
                    (Op::TypeSampledImage, _) => Some(BindingKind::CombinedImageSampler),
                    (Op::TypeImage, Some(Operand::LiteralBit32(2))) => Some(BindingKind::StorageImage),
                    (Op::TypeImage, _) => Some(BindingKind::SampledImage),
                    _ => None,
                }
            }
            _ => None,
        }
    }

    fn all_read_only(&self, block: Word) -> bool {
        let members = self.types.get(&block).map_or(0, |block| block.operands.len());
        (0..members).all(|member| {
            self.module.annotations.iter().any(|annotation| {
                annotation.class.opcode == Op::MemberDecorate
                    && annotation.operands[0] == Operand::IdRef(block)
                    && annotation.operands[1] == Operand::LiteralBit32(u32::try_from(member).unwrap_or(0))
                    && annotation.operands[2] == Operand::Decoration(Decoration::NonWritable)
            })
        })
    }

    fn group_size(&self) -> [u32; 3] {
        let mode = self
            .module
            .execution_modes
            .iter()
            .find(|mode| mode.operands.get(1) == Some(&Operand::ExecutionMode(ExecutionMode::LocalSize)));
        let at = |index: usize| match mode.and_then(|mode| mode.operands.get(index)) {
            Some(Operand::LiteralBit32(size)) => *size,
            _ => 0,
        };
        [at(2), at(3), at(4)]
    }

    fn members(&self, id: Word, instruction: &Instruction) -> Vec<(String, u32)> {
        (0u32..)
            .zip(&instruction.operands)
            .map(|(member, _)| {
                let name = self.member_names.get(&(id, member)).copied().unwrap_or_default();
                (name.to_owned(), self.member_decoration(id, member, Decoration::Offset).unwrap_or(0))
            })
            .collect()
    }

    /// Size in bytes of a type in a push-constant block: scalar, vector, matrix, array or struct.
    fn size_of(&self, id: Word) -> u32 {
        let Some(instruction) = self.types.get(&id) else { return 0 };
        let literal = |index: usize| match instruction.operands.get(index) {
            Some(Operand::LiteralBit32(value)) => *value,
            _ => 0,
        };
        match instruction.class.opcode {
            Op::TypeInt | Op::TypeFloat => literal(0) / 8,
            Op::TypeVector => self.size_of(id_at(instruction, 0)) * literal(1),
            Op::TypeMatrix => 16 * literal(1),
            Op::TypeArray => {
                let length = self.types.get(&id_at(instruction, 1)).map_or(0, |constant| {
                    match constant.operands.first() {
                        Some(Operand::LiteralBit32(value)) => *value,
                        _ => 0,
                    }
                });
                self.decoration(id, Decoration::ArrayStride).unwrap_or(0) * length
            }
            Op::TypeStruct => (0u32..)
                .zip(&instruction.operands)
                .map(|(member, operand)| {
                    let offset = self.member_decoration(id, member, Decoration::Offset).unwrap_or(0);
                    let Operand::IdRef(kind) = operand else { return offset };
                    offset + self.size_of(*kind)
                })
                .max()
                .unwrap_or(0),
            _ => 0,
        }
    }

    fn decoration(&self, id: Word, decoration: Decoration) -> Option<u32> {
        self.module.annotations.iter().find_map(|annotation| {
            match (annotation.class.opcode, annotation.operands.as_slice()) {
                (
                    Op::Decorate,
                    [Operand::IdRef(target), Operand::Decoration(found), Operand::LiteralBit32(value)],
                ) if *target == id && *found == decoration => Some(*value),
                _ => None,
            }
        })
    }

    fn member_decoration(&self, id: Word, member: u32, decoration: Decoration) -> Option<u32> {
        self.module.annotations.iter().find_map(|annotation| {
            match (annotation.class.opcode, annotation.operands.as_slice()) {
                (
                    Op::MemberDecorate,
                    [
                        Operand::IdRef(target),
                        Operand::LiteralBit32(index),
                        Operand::Decoration(found),
                        Operand::LiteralBit32(value),
                    ],
                ) if *target == id && *index == member && *found == decoration => Some(*value),
                _ => None,
            }
        })
    }
}

fn id_at(instruction: &Instruction, index: usize) -> Word {
    match instruction.operands.get(index) {
        Some(Operand::IdRef(id)) => *id,
        _ => 0,
    }
}
