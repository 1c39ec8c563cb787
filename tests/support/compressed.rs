//! A bumpy sheet of 5 x 5 vertices, plain and compressed: base64 of what the C++ encoders of meshoptimizer and Draco make of it.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

/// Positions by the vertex codec, version 0.
pub const POSITIONS: &str = "oAAABwD//4CA////gID///+AgP///8AA//+AgP///4CABTg+D4N+f35/fn/g+AAAfn9+AAAFADAMA///gADAAACAAQAwCAB+\
    AAAFAAPDz////////wAPAAD//wUADP8/fn1+fX59fn0AM8AAfn1+AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA=";
/// The same, version 1.
pub const POSITIONS_1: &str = "oVoaWgA454CA/4CA/4CA/5wBgID/gIAFND0PQ3+Af4B/gND0AAB/gH8AAICAEACAASAEfwEAgNn////////AAP//AEDvfn\
    1+fX59fn2gAX59fgAAAAAAAAAAAAAAAAAAAAAAAAAAAAEBAA==";
/// The same through the exponential filter, of 15 bits.
pub const POSITIONS_EXPONENTIAL: &str = "oAAHAEAAIB8/QAAgHz9AACAfP8/zwABAIB8/QCAfAAUoui6LBQUFouiAAAUABQAwAANAIADAAAAfAAUAIAgA\
    AIAAAAAFAAz/P0A/QD9AP0A/ADPAAEA/QAAFAAJCSQAJAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAPIAAADyAAAA8g==";
/// Normals through the octahedral filter, of 8 bits.
pub const NORMALS_OCTAHEDRAL: &str = "oAcAHioqHpsiMjIiuSZAQCa5///AACIyMiKbHioqHgoL/8996PAADxESHioqjtf8/7AAAAAeEhEAAAAAAAAAAAA\
    AAAAAAAAAAAAAAAAAAAAAAAAAAADc3H8A";
/// Turns about z by 0, 45 and 90 degrees through the quaternion filter.
pub const TURNS: &str =
    "oAEEAAAAAQwAAAAOAAABPAAAAKinATwAAAAIBwEEAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAP8H";
/// The triangles.
pub const TRIANGLES: &str = "4f7+/v7+/v7+///////////////+/v7+/v7+/v7+/v7+DwzyAvIC8gJ/BH8CfwJ/An8HDH8JDH8JDH8JDH8HDH8JDH8JDH8J\
    DP8vDAHyBwzxCQwfCXAaGBdQFhYWUBYWFgB2h1ZneKmGZYlomAFpAAA=";
/// The same as a strip of 46 indices.
pub const STRIP: &str = "0RQSGBIYEhgSGBIAGAASGBIYEhgSGBIAGAASGBIYEhgSGBIAGAASGBIYEhgSGBIAAAAA";
/// Draco, edgebreaker with standard connectivity: colours 0, texture coordinates 1, normals 2, positions 3.
pub const EDGEBREAKER: &str = "RFJBQ08CAgEBAAAAGSADIAQACl/71FN9qlrVpwr/ARH/AsxC/wLMQv8CzEIEAAAAAQAAAgAA/wAAAQICBAEAAQEDCQIBAQ\
    IBAQkDAAIDAQAJAwADAgEBAQEC8QGFO0kB/9Ok7QH/26QJLOJmIDDemF+AAAAAAP8AAAABAQEADQOFK80MH5ECIQUGIlbNv95/APj/AOh//wcABgogACGACAA\
    AAAD/DwAAAAAAAAAAAAAAAIA/DAADAQANH7EHsQeRAiEF8SgHqI5wlyaIVQD4LwAANjvml3kAJDJHhMxnRjNnRjM3E818VTCrquoAEDYpSQCwvecDuCrMBLP7\
    v2Y0g7sDqDoJCw/qScLsAPC/6sJPAv8PAAD/BwAADAEBAQAPAz0KJ10PuR6xBwikNoCxuIqOhwDg/w8AAoD+3//3/wEAAAAABAAAMAAAgP8PACAAACAACAD/H\
    wAAgP8PAADw/wAAAgAAAgAA/D8AAAD+HwAAAAAIAADw/wEAAPx/CAAAAAABAAD+HwAAAAAIAADw/wAgAPx/ACAAACAAAAAA/z8AAAAAAAAAAAAAAAAAAAAAgE\
    AO";
/// The same with valence connectivity.
pub const VALENCE: &str = "RFJBQ08CAgEBAAAAGSADIAQACl/71FN9qlrVpwr/ARH/AsxC/wLMQv8CzEIEAAAA/wABAQAAAgAAAQICBAEAAQEACQMAAwIBAw\
    kCAQECAQEJAwACAwEBAQEF8QGFO0kB/9Ok7QH/26QJLOJmIDDemF+AAAAAAP8AAAABAQEADwM9CpECIz0KvR49CggXHyFzWajGfwDg/w8AAoD+3//3/wEAAAA\
    ABAAAMAAAgP8PACAAACAACAD/HwAAgP8PAADw/wAAAgAAAgAA/D8AAAD+HwAAAAAYAADA/xcAgAAAgAAAAAAAAoAA8P8BAAD4/xAAAAAAAgAA/D8AAAAA/z8A\
    AAAAAAAAAAAAAAAAAAAAgEAOBQEBAA0D6REPkQKxByEF6REDsQchBQr0eFD5TT0yky+lAPj/AOh/jzMiEQACIH/5xAnNACADQA9wrQeouAwZgEQACHoAoHKED\
    ECJABcAAAALA/mvgwAAAAD/DwAAAAAAAAAAAAAAAIA/DAYDAQANG5ECAz0KPQohBdkjCO93Z5hRSnyHVVH1ZwCYOTPNH5pV4ChzZlVR1Yiw+11A9lUx8wFS2Y\
    whopckeix811f1VD/zdp8ZACv8s4hnNvowdh3Amc+M86p7/nkB/w8AAP8HAAD/ArNBDA==";
/// The same, sequential.
pub const SEQUENTIAL: &str = "RFJBQ08CAgEAAAAgGQEAAQYBAgcCAwgDBAkFBgsGBwwHCA0ICQ4KCxALDBEMDRINDhMPEBUQERYREhcSExgABgUBBwYCCAc\
    DCQgFCwoGDAsHDQwIDg0KEA8LERAMEhENExIPFRQQFhURFxYSGBcBBAICBAEAAwkCAQEBCQMAAgAJAwADAQIDAgABAQECec0sSQF3kQL/W10PEZTiD5he3fBl\
    vAFRsel6NtiBAAAAAP8AAAAAAQEBAoEQJRwDIQX/////////////////////////////////////////67EHAw0XDfiRH307Dv5HQ5JAk4sAAAAA/w8AAAADA\
    QANH10PsQeRAgNlJgcgmdnEQD6Itt02bO/5M2/3zImTYcKc5DK/+82O+TLPNBMBMCIxOwD8NwAACMBMACH+P7sv85jf7GdkEjULc5J7Ptvb/cwnModNAv8PAA\
    D/BwAAAAEBAA8DkQIrXQ8VLgafACUVgIAAAAEAAAAABAAAAP8PAAAAAAgAAAACAAAIAACAAAAABAACAACQ/wcA/x8ABAAAIAEAAPx/AEAAAAAEAAGA/8f/A4D\
    /BwACAACgAPD//x8ABAAAAAAQAAAA/D8AAAAAIAAAAAgAACAAAAACAAAQAAgAAED+HwD8fwAQAACAAAAAAAD/PwAAAAAAAAAAAAAAAIA/DAwAAAAAAAAAAAAA\
    AAAAAIBADg==";

/// A document and its buffer, being written.
#[derive(Default)]
struct Writer {
    views: Vec<Value>,
    accessors: Vec<Value>,
    bytes: Vec<u8>,
}

impl Writer {
    /// Adds a view with members beside its range; returns its index.
    fn view(&mut self, data: &[u8]) -> usize {
        self.views.push(json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": data.len() }));
        self.bytes.extend(data);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.len() - 1
    }

    /// Adds a view of `count` elements of `stride` bytes, which a stream of meshoptimizer becomes.
    fn packed(
        &mut self,
        extension: &str,
        stream: &str,
        kind: &Value,
        (count, stride): (usize, usize),
    ) -> usize {
        let data = STANDARD.decode(stream).unwrap();
        let view = self.view(&data);
        let mut packed = kind.clone();
        for (key, value) in [("buffer", json!(0)), ("byteOffset", self.views[view]["byteOffset"].clone())] {
            packed[key] = value;
        }
        for (key, value) in [("byteLength", data.len()), ("byteStride", stride), ("count", count)] {
            packed[key] = json!(value);
        }
        self.views[view] =
            json!({ "buffer": 1, "byteLength": count * stride, "extensions": { extension: packed } });
        view
    }

    fn accessor(&mut self, view: Option<usize>, component: u32, kind: &str, count: usize) -> usize {
        let mut accessor =
            json!({ "componentType": component, "type": kind, "count": count, "min": [0], "max": [9] });
        if let Some(view) = view {
            accessor["bufferView"] = json!(view);
        }
        accessor["normalized"] = json!(component == 5120 || component == 5121 || component == 5122);
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    fn document(self, primitive: &Value, extensions: &[&str]) -> (Value, Vec<u8>) {
        let document = json!({
            "asset": { "version": "2.0" }, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }],
            "meshes": [{ "primitives": [primitive] }], "extensionsUsed": extensions, "extensionsRequired": extensions,
            "bufferViews": self.views, "accessors": self.accessors, "buffers": [{ "byteLength": self.bytes.len() }],
        });
        (document, self.bytes)
    }
}

fn bytes_of(values: impl IntoIterator<Item = f32>) -> Vec<u8> {
    values.into_iter().flat_map(f32::to_le_bytes).collect()
}

/// The sheet as it is.
pub fn plain() -> (Value, Vec<u8>) {
    let places = || (0..25u8).map(|i| (i % 5, i / 5));
    let positions = places().flat_map(|(x, y)| [f32::from(x), f32::from(y), f32::from(x * y % 3) * 0.5]);
    let normal = |(x, y)| glam::vec3(f32::from(x) - 2.0, f32::from(y) - 2.0, 3.0).normalize().to_array();
    let uvs = places().flat_map(|(x, y)| [f32::from(x) / 4.0, f32::from(y) / 4.0]);
    let colours: Vec<u8> = places().flat_map(|(x, y)| [x * 60, y * 60, 255, 255]).collect();
    let mut writer = Writer::default();
    let attributes = [
        ("POSITION", bytes_of(positions), 5126, "VEC3"),
        ("NORMAL", bytes_of(places().flat_map(normal)), 5126, "VEC3"),
        ("TEXCOORD_0", bytes_of(uvs), 5126, "VEC2"),
        ("COLOR_0", colours, 5121, "VEC4"),
    ];
    let mut primitive = json!({ "attributes": {} });
    for (name, data, component, kind) in attributes {
        let view = writer.view(&data);
        primitive["attributes"][name] = json!(writer.accessor(Some(view), component, kind, 25));
    }
    let corners = |(x, y)| [(x, y), (x + 1, y), (x + 1, y + 1), (x, y), (x + 1, y + 1), (x, y + 1)];
    let squares = places().filter(|(x, y)| *x < 4 && *y < 4);
    let indices: Vec<u8> = squares.flat_map(corners).map(|(x, y)| 5 * y + x).collect();
    let view = writer.view(&indices);
    primitive["indices"] = json!(writer.accessor(Some(view), 5121, "SCALAR", 96));
    writer.document(&primitive, &[])
}

/// The sheet by meshoptimizer: positions and normals, as triangles or a strip; and an animation that turns it.
pub fn meshopt(extension: &str, positions: &str, filter: &str, is_strip: bool) -> (Value, Vec<u8>) {
    let mut writer = Writer::default();
    let attributes = |filter: &str| json!({ "mode": "ATTRIBUTES", "filter": filter });
    let view = writer.packed(extension, positions, &attributes(filter), (25, 12));
    let positions = writer.accessor(Some(view), 5126, "VEC3", 25);
    let view = writer.packed(extension, NORMALS_OCTAHEDRAL, &attributes("OCTAHEDRAL"), (25, 4));
    let normals = writer.accessor(Some(view), 5120, "VEC3", 25);
    let (stream, mode, count, primitive_mode) =
        if is_strip { (STRIP, "INDICES", 46, 5) } else { (TRIANGLES, "TRIANGLES", 96, 4) };
    let view = writer.packed(extension, stream, &json!({ "mode": mode }), (count, 2));
    let indices = writer.accessor(Some(view), 5123, "SCALAR", count);
    let view = writer.packed(extension, TURNS, &attributes("QUATERNION"), (3, 8));
    let turns = writer.accessor(Some(view), 5122, "VEC4", 3);
    let view = writer.view(&bytes_of([0.0, 1.0, 2.0]));
    let times = writer.accessor(Some(view), 5126, "SCALAR", 3);
    let primitive = json!({ "attributes": { "POSITION": positions, "NORMAL": normals }, "indices": indices, "mode": primitive_mode });
    let (mut document, bytes) = writer.document(&primitive, &[extension, "KHR_mesh_quantization"]);
    let fallback = json!({ "byteLength": 1000, "extensions": { extension: { "fallback": true } } });
    document["buffers"].as_array_mut().unwrap().push(fallback);
    document["animations"] = json!([{ "samplers": [{ "input": times, "output": turns }],
        "channels": [{ "sampler": 0, "target": { "node": 0, "path": "rotation" } }] }]);
    (document, bytes)
}

/// The sheet by Draco.
pub fn draco(stream: &str) -> (Value, Vec<u8>) {
    let mut writer = Writer::default();
    let view = writer.view(&STANDARD.decode(stream).unwrap());
    let mut accessor = |component, kind, count| writer.accessor(None, component, kind, count);
    let attributes = json!({ "POSITION": accessor(5126, "VEC3", 25), "NORMAL": accessor(5126, "VEC3", 25),
        "TEXCOORD_0": accessor(5126, "VEC2", 25), "COLOR_0": accessor(5121, "VEC4", 25) });
    let indices = accessor(5123, "SCALAR", 96);
    let places = json!({ "COLOR_0": 0, "TEXCOORD_0": 1, "NORMAL": 2, "POSITION": 3 });
    let extension = "KHR_draco_mesh_compression";
    let primitive = json!({ "attributes": attributes, "indices": indices,
        "extensions": { extension: { "bufferView": view, "attributes": places } } });
    writer.document(&primitive, &[extension])
}
