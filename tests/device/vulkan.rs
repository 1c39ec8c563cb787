//! The Vulkan layer on a real device, with validation: bindings by name, barriers, uploads, limits.

use crate::support::GpuFixture;
use glowworm::vulkan::{
    Buffer, ComputePipeline, Frames, Image, ImageDescription, Mirror, Upload, VulkanError, shaders, vk,
};

/// Asserts that the error names the pass `add`, this binding and this problem.
#[track_caller]
fn assert_binding(result: Result<(), VulkanError>, wanted: &str, says: &str) {
    let error = result.unwrap_err();
    let VulkanError::Binding { pass, binding, problem } = &error else { panic!("{error}") };
    assert_eq!((pass.as_str(), binding.as_str()), ("add", wanted), "{error}");
    assert!(problem.contains(says), "{error}");
    assert!(!error.to_string().contains('\n'));
}

fn adder(gpu: &GpuFixture) -> ComputePipeline {
    ComputePipeline::new(&gpu.device, "add", shaders::ADD_COMP).unwrap()
}

fn words(gpu: &GpuFixture, buffer: &Buffer) -> Vec<u32> {
    bytemuck::pod_collect_to_vec(&buffer.read(&gpu.device).unwrap())
}

fn image(gpu: &GpuFixture, name: &str, extent: [u32; 2], layers: Option<u32>) -> Result<Image, VulkanError> {
    let description = ImageDescription {
        name,
        format: vk::Format::R32_SFLOAT,
        extent,
        layers,
        levels: 1,
        usage: vk::ImageUsageFlags::STORAGE,
    };
    Image::new(&gpu.device, &description)
}

#[test]
fn a_wrong_binding_is_an_error_that_names_it() {
    let Some(gpu) = GpuFixture::open() else { return };
    let add = adder(&gpu);
    let source = Buffer::with_data(&gpu.device, "source", &[1u32; 64]).unwrap();
    let target = Buffer::with_data(&gpu.device, "target", &[0u32; 64]).unwrap();
    let picture = image(&gpu, "picture", [8, 8], None).unwrap();
    let mut frames = Frames::new(&gpu.device).unwrap();
    let threads = [64, 1, 1];

    let (mut frame, _) = frames.begin().unwrap();
    let pass = frame.pass("add", &add).read("source", &source).push(&5u32);
    assert_binding(pass.dispatch_threads(threads), "target", "is missing");

    let (mut frame, _) = frames.begin().unwrap();
    let pass = frame.pass("add", &add).read("source", &source).write("target", &target).push(&5u32);
    assert_binding(pass.read("extra", &source).dispatch_threads(threads), "extra", "is not in the shader");

    let (mut frame, _) = frames.begin().unwrap();
    let pass = frame.pass("add", &add).write("source", &source).write("target", &target).push(&5u32);
    assert_binding(pass.dispatch_threads(threads), "source", "a buffer to write was given");

    let (mut frame, _) = frames.begin().unwrap();
    let pass = frame.pass("add", &add).read("source", &source).read("target", &target).push(&5u32);
    assert_binding(pass.dispatch_threads(threads), "target", "a buffer to read was given");

    let (mut frame, _) = frames.begin().unwrap();
    let pass = frame.pass("add", &add).read("source", &picture).write("target", &target).push(&5u32);
    assert_binding(pass.dispatch_threads(threads), "source", "an image to read was given");

    let (mut frame, _) = frames.begin().unwrap();
    let pass = frame.pass("add", &add).read("source", &source).write("target", &target).push(&5u64);
    assert_binding(pass.dispatch_threads(threads), "push constants", "have 8 bytes, not 4");

    let (mut frame, _) = frames.begin().unwrap();
    let pass = frame.pass("add", &add).read("source", &source).write("target", &target);
    assert_binding(pass.dispatch_threads(threads), "push constants", "have 0 bytes, not 4");

    // A correct pass still works after these errors.
    let (mut frame, _) = frames.begin().unwrap();
    let pass = frame.pass("add", &add).read("source", &source).write("target", &target).push(&5u32);
    pass.dispatch_threads(threads).unwrap();
    frame.submit().unwrap();
    assert_eq!(words(&gpu, &target), [6; 64]);
}

#[test]
fn mirrors_upload_what_has_changed_and_no_more() {
    let Some(gpu) = GpuFixture::open() else { return };
    let add = adder(&gpu);
    let target = Buffer::with_data(&gpu.device, "target", &[0u32; 64]).unwrap();
    let mut mirror = Mirror::new(&gpu.device, "mirror", 64 * 4).unwrap();
    let mut frames = Frames::new(&gpu.device).unwrap();
    let mut data: Vec<u32> = (0..60).collect();
    let mut step = |data: &[u32], uploads: usize| {
        let (mut frame, _) = frames.begin().unwrap();
        assert_eq!(mirror.update(&mut frame, 16, data).unwrap(), uploads);
        let source = std::sync::Arc::clone(mirror.buffer());
        let pass = frame.pass("add", &add).read("source", &*source).write("target", &target).push(&1u32);
        pass.dispatch_threads([64, 1, 1]).unwrap();
        frame.submit().unwrap();
        let wanted: Vec<u32> = [0; 4].iter().chain(data).map(|word| word + 1).collect();
        assert_eq!(words(&gpu, &target), wanted);
    };
    step(&data, 59);
    step(&data, 0);
    for changed in [0, 7, 8, 59] {
        data[changed] += 1000;
    }
    step(&data, 4);
    step(&data, 0);
}

#[test]
fn each_pass_sees_what_the_one_before_wrote() {
    let Some(gpu) = GpuFixture::open() else { return };
    const COUNT: u32 = 100_000;
    let add = adder(&gpu);
    let start: Vec<u32> = (0..COUNT).collect();
    let buffers =
        ["even", "odd"].map(|name| Buffer::with_data(&gpu.device, name, &vec![0u32; start.len()]).unwrap());
    let mut frames = Frames::new(&gpu.device).unwrap();
    // Through copies, clears and passes, within frames and across them.
    for _ in 0..4 {
        let (mut frame, _) = frames.begin().unwrap();
        let uploaded = frame.upload(&start).unwrap();
        frame.copy(&uploaded, &buffers[0], 0);
        frame.clear(&buffers[1]);
        for step in 0..10u32 {
            let (source, target) = (&buffers[step as usize % 2], &buffers[(step as usize + 1) % 2]);
            let pass = frame.pass("add", &add).read("source", source).write("target", target);
            pass.push(&(step + 1)).dispatch_threads([COUNT, 1, 1]).unwrap();
        }
        frame.copy(&buffers[0], &buffers[1], 0);
        frame.submit().unwrap();
    }
    let expected: Vec<u32> = start.iter().map(|word| word + 55).collect();
    assert!(words(&gpu, &buffers[0]) == expected);
    assert!(words(&gpu, &buffers[1]) == expected);
}

#[test]
fn images_change_between_storage_and_texture() {
    let Some(gpu) = GpuFixture::open() else { return };
    let extent = [37, 19];
    let add = ComputePipeline::new(&gpu.device, "add_image", shaders::ADD_IMAGE_COMP).unwrap();
    let images = ["even", "odd"].map(|name| image(&gpu, name, extent, None).unwrap());
    let zeros = Image::with_levels(
        &gpu.device,
        "zeros",
        vk::Format::R8G8B8A8_SRGB,
        &[(37, 19, vec![0; 37 * 19 * 4])],
    )
    .unwrap();
    let mut frames = Frames::new(&gpu.device).unwrap();
    let (mut frame, _) = frames.begin().unwrap();
    let pass = frame.pass("add_image", &add).read("source", &zeros).write("target", &images[0]);
    pass.push(&0.5f32).dispatch_over(extent).unwrap();
    for step in 0..10 {
        let (source, target) = (&images[step % 2], &images[(step + 1) % 2]);
        let pass = frame.pass("add_image", &add).read("source", source).write("target", target);
        pass.push(&1.0f32).dispatch_over(extent).unwrap();
    }
    frame.submit().unwrap();
    let texels: Vec<f32> = bytemuck::pod_collect_to_vec(&images[0].read_layer(&gpu.device, 0, 4).unwrap());
    assert_eq!(texels, [10.5; 37 * 19]);
}

#[test]
fn uploads_may_be_larger_than_a_chunk() {
    let Some(gpu) = GpuFixture::open() else { return };
    let mut frames = Frames::new(&gpu.device).unwrap();
    // Sizes around and far above a chunk of 1 MiB; later frames reuse what earlier ones grew.
    for round in 0..4u32 {
        let blocks: Vec<Vec<u32>> = [1, 262_143, 262_145, 3, 1_000_000, 5]
            .iter()
            .zip(1u32..)
            .map(|(&count, block)| (0..count).map(|word| word * 31 + block * 7 + round).collect())
            .collect();
        let targets: Vec<Buffer> = blocks
            .iter()
            .map(|block| Buffer::new(&gpu.device, "target", block.len() as u64 * 4).unwrap())
            .collect();
        let (mut frame, _) = frames.begin().unwrap();
        let uploads: Vec<Upload> = blocks.iter().map(|block| frame.upload(block).unwrap()).collect();
        for (upload, target) in uploads.iter().zip(&targets) {
            frame.copy(upload, target, 0);
        }
        frame.submit().unwrap();
        for (block, target) in blocks.iter().zip(&targets) {
            assert!(words(&gpu, target).starts_with(block), "{} words in round {round}", block.len());
        }
    }
}

#[test]
fn what_is_too_large_for_the_device_is_an_error_that_says_so() {
    let Some(gpu) = GpuFixture::open() else { return };
    let limits = gpu.device.limits();
    let side = limits.max_image_dimension2_d + 1;
    let layers = limits.max_image_array_layers + 1;
    let bytes = u64::from(limits.max_storage_buffer_range) + 1;
    for (error, name) in [
        (image(&gpu, "wide", [side, 1], None).err(), "wide"),
        (image(&gpu, "high", [1, side], None).err(), "high"),
        (image(&gpu, "deep", [1, 1], Some(layers)).err(), "deep"),
        (Buffer::new(&gpu.device, "long", bytes).err(), "long"),
    ] {
        let error = error.unwrap();
        assert!(matches!(error, VulkanError::Limit { .. }), "{error}");
        assert!(error.to_string().contains(name), "{error}");
    }
    // Each extent is possible, but not all of them at once; which limit that meets is the driver's choice.
    let vast = image(&gpu, "vast", [side - 1; 2], Some(layers - 1)).err().unwrap().to_string();
    assert!(vast.contains("vast") && !vast.contains('\n'), "{vast}");
    let add = adder(&gpu);
    let buffer = Buffer::with_data(&gpu.device, "words", &[0u32; 64]).unwrap();
    let other = Buffer::with_data(&gpu.device, "other", &[0u32; 64]).unwrap();
    let mut frames = Frames::new(&gpu.device).unwrap();
    let (mut frame, _) = frames.begin().unwrap();
    let pass = frame.pass("add", &add).read("source", &buffer).write("target", &other).push(&1u32);
    let rows = limits.max_compute_work_group_count[1] + 1;
    let error = pass.dispatch_threads([64, rows, 1]).unwrap_err();
    assert!(matches!(error, VulkanError::Limit { .. }) && error.to_string().contains("pass add"), "{error}");
}
