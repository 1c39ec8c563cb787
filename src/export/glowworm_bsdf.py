"""glowworm's surfaces as a BSDF of Mitsuba 3: glTF 2.0's metallic-roughness with energy compensation, and thin surfaces.

    python glowworm_bsdf.py [PICTURE.exr]     renders scene.xml beside this file with it
    import glowworm_bsdf                      registers it, once a variant is set; then
    mi.load_file("scene.xml", materials=glowworm_bsdf.MATERIALS)

Without this file, `mitsuba scene.xml` renders Mitsuba's own materials, which come near. The equations are those of
src/bsdf.rs. Parameters: base_color (spectrum or texture), metallic and roughness (number or texture), f0 (spectrum) and
f90 (number): reflectance of the dielectric at normal and grazing incidence; transmission (number): share of the base
colour that passes as through a thin surface; vertex_color (texture): a factor of the base colour; normal_map (texture) and
normal_scale (number), in the frame of vertex_tangent, whose bitangent's side is vertex_side. Both sides are the same.
"""

import sys
from pathlib import Path

import drjit as dr
import mitsuba as mi

if __name__ == "__main__":
    mi.set_variant("llvm_ad_rgb", "scalar_rgb")

# What scene.xml includes in place of Mitsuba's own materials.
MATERIALS = "materials-glowworm.xml"
# Smoother surfaces are perfect mirrors.
MIRROR_ROUGHNESS = 0.03
# Least cosine between the normal of a normal map and the triangle's.
LEAST_COSINE = 0.01
# Least cosine between normal and eye.
GRAZING = 1e-4
# Polynomials of single_scattering: for each power of x, the coefficients by roughness.
WHITE = [
    [0.99802, 0.37004, -2.7373, 6.6617, -6.5214, 2.22],
    [-0.4763, 1.2122, 0.4362, -6.4368, 3.245],
    [2.3485, -4.302, 8.3688, -1.3877],
    [-7.0895, 1.4425, -4.7184],
    [8.9347, 1.1073],
    [-3.7046],
]
ROOT = [
    [1.0028, -0.17455, -7.136, -6.6293, 33.98, 14.382],
    [0.012093, 6.6914, 37.516, -56.569, -77.934],
    [-2.0491, -31.082, -13.404, 111.7],
    [5.5349, 40.672, -39.527],
    [-9.3604, -12.035],
    [4.9426],
]


def polynomial(coefficients, x):
    total = 0.0
    for coefficient in reversed(coefficients):
        total = total * x + coefficient
    return total


def fifth(x):
    return dr.square(dr.square(x)) * x


def single_scattering(cosine, roughness):
    """What GGX microfacets reflect at the first try, for Fresnel reflectance 1 and for (1 - c)^5."""
    alpha = dr.square(roughness)
    white = polynomial([polynomial(row, roughness) for row in WHITE], cosine / (cosine + 0.5 * alpha))
    root = polynomial([polynomial(row, roughness) for row in ROOT], dr.sqrt(cosine + alpha))
    white = dr.clip(white, 0, 1)
    return white, white * fifth(dr.clip(root, 0, 1))


def distribution(normal, half, alpha):
    squared = dr.square(alpha)
    total = squared * dr.square(dr.dot(normal, half)) + dr.squared_norm(dr.cross(normal, half))
    return squared / dr.maximum(dr.pi * dr.square(total), 1e-37)


def lengthened(cosine, alpha):
    squared = dr.square(alpha)
    return dr.sqrt(squared + (1 - squared) * dr.square(cosine))


def largest(colour):
    return dr.maximum(colour[0], dr.maximum(colour[1], colour[2]))


class Seen:
    """A surface seen from one side, with what does not depend on the direction of the light. All is in the local frame
    of the interaction."""

    def __init__(self, bsdf, si, active):
        # The side is that of the triangle which the eye sees; a shading normal that faces away is bent until it does not.
        self.eye = si.wi
        flat = si.to_local(si.n)
        self.flat = dr.select(dr.dot(flat, self.eye) < 0, -flat, flat)
        side = dr.select(self.flat.z < 0, mi.Float(-1), mi.Float(1))
        normal = mi.Vector3f(0, 0, 1) * side
        if bsdf.normal_map is not None:
            mapped = bsdf.mapped_normal(si, active) * side
            below = LEAST_COSINE - dr.dot(mapped, self.flat)
            normal = dr.select(below > 0, dr.normalize(mapped + self.flat * below), mapped)
        cosine = dr.dot(normal, self.eye)
        bent = dr.normalize(normal + self.eye * (GRAZING - cosine))
        self.normal = dr.select(cosine < GRAZING, bent, normal)
        self.cosine = cosine = dr.maximum(cosine, GRAZING)

        colour = bsdf.base_color.eval(si, active)
        if bsdf.vertex_color is not None:
            colour *= bsdf.vertex_color.eval_3(si, active)
        metallic = dr.clip(bsdf.metallic.eval_1(si, active), 0, 1)
        roughness = dr.clip(bsdf.roughness.eval_1(si, active), 0, 1)
        base = colour * (1 - bsdf.transmission)
        self.mirror = roughness < MIRROR_ROUGHNESS
        self.alpha = dr.square(dr.maximum(roughness, MIRROR_ROUGHNESS))

        # Dielectric and metal each get back what is scattered more than once.
        white, grazing = single_scattering(cosine, dr.maximum(roughness, MIRROR_ROUGHNESS))
        white = dr.select(self.mirror, 1, white)
        grazing = dr.select(self.mirror, fifth(1 - cosine), grazing)
        again = 1 / white - 1
        given = bsdf.f0.eval(si, active)
        dielectric, metal = 1 + given * again, 1 + base * again
        f0, f90 = given * dielectric, dielectric * bsdf.f90
        over = dr.minimum(largest(f0 * (white - grazing) + f90 * grazing), 1)
        self.diffuse = base * ((1 - metallic) * (1 - over))
        self.f0 = dr.lerp(f0, base * metal, metallic)
        self.f90 = dr.lerp(f90, metal, metallic)
        reflected = dr.minimum(largest(self.f0 * (white - grazing) + self.f90 * grazing), 1)

        # A direction is drawn of what passes, of the GGX lobe or of the Lambertian one, in proportion to their albedos.
        self.passed = colour * (bsdf.transmission * (1 - reflected))
        self.passing = largest(self.passed)
        self.share = dr.select(reflected > 0, reflected / (reflected + largest(self.diffuse)), 0)

    def fresnel(self, cosine):
        return self.f0 + (self.f90 - self.f0) * fifth(dr.clip(1 - cosine, 0, 1))

    def meets(self, light):
        return (dr.dot(self.normal, light) > 0) & (dr.dot(self.flat, light) > 0)

    def eval_pdf(self, light):
        """The smooth lobes times the cosine, and the density of the directions drawn for them."""
        cosine = dr.maximum(dr.dot(self.normal, light), 0)
        half = dr.normalize(self.eye + light)
        facets = distribution(self.normal, half, self.alpha)
        eye_length, light_length = lengthened(self.cosine, self.alpha), lengthened(cosine, self.alpha)
        visibility = 0.5 / dr.maximum(cosine * eye_length + self.cosine * light_length, 1e-37)
        reflected = self.fresnel(dr.dot(self.eye, half)) * (facets * visibility)
        value = (self.diffuse * dr.inv_pi + dr.select(self.mirror, 0, reflected)) * cosine
        visible = dr.select(self.mirror, 0, facets * 0.5 / (self.cosine + eye_length))
        density = self.share * visible + (1 - self.share) * cosine * dr.inv_pi
        ahead = self.meets(light)
        return dr.select(ahead, value, 0), dr.select(ahead, density * (1 - self.passing), 0)

    def visible_normal(self, u):
        """A normal of a microfacet that the eye sees (Heitz 2018; Dupuy and Benyoub 2023)."""
        frame = mi.Frame3f(self.normal)
        eye = frame.to_local(self.eye)
        stretched = dr.normalize(mi.Vector3f(self.alpha * eye.x, self.alpha * eye.y, self.cosine))
        z = (1 - u.y) * (1 + stretched.z) - stretched.z
        sin, cos = dr.sincos(dr.two_pi * u.x)
        radius = dr.safe_sqrt(1 - dr.square(z))
        cap = mi.Vector3f(radius * cos, radius * sin, z) + stretched
        return frame.to_world(dr.normalize(mi.Vector3f(self.alpha * cap.x, self.alpha * cap.y, dr.maximum(cap.z, 0))))


class Glowworm(mi.BSDF):
    def __init__(self, props):
        mi.BSDF.__init__(self, props)
        self.base_color = props.get_texture("base_color", 0.5)
        self.metallic = props.get_texture("metallic", 0.0)
        self.roughness = props.get_texture("roughness", 1.0)
        self.f0 = props.get_texture("f0", 0.04)
        self.f90 = props.get("f90", 1.0)
        self.transmission = props.get("transmission", 0.0)
        details = ["vertex_color", "normal_map", "vertex_tangent", "vertex_side"]
        self.vertex_color, self.normal_map, self.vertex_tangent, self.vertex_side = (
            props.get_texture(name) if name in props else None for name in details)
        self.normal_scale = props.get("normal_scale", 1.0)
        kinds = [mi.BSDFFlags.DiffuseReflection, mi.BSDFFlags.GlossyReflection, mi.BSDFFlags.DeltaReflection]
        kinds += [mi.BSDFFlags.Null] if self.transmission > 0 else []
        sides = mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
        self.m_components = [kind | sides for kind in kinds]
        self.m_flags = self.m_components[0]
        for component in self.m_components:
            self.m_flags |= component

    def mapped_normal(self, si, active):
        """The normal of the normal map, in the local frame."""
        x, y, z = self.normal_map.eval_3(si, active) * 2 - 1
        tangent = si.to_local(mi.Vector3f(self.vertex_tangent.eval_3(si, active)))
        side = self.vertex_side.eval_1(si, active)
        length = dr.norm(tangent)
        tangent /= dr.maximum(length, 1e-20)
        up = mi.Vector3f(0, 0, 1)
        slope = (tangent * x + dr.cross(up, tangent) * dr.sign(side) * y) * self.normal_scale
        mapped = slope + up * z
        is_mapped = (side != 0) & (length > 0) & (dr.squared_norm(mapped) > 0)
        return dr.select(is_mapped, dr.normalize(mapped), up)

    def sample(self, ctx, si, sample1, sample2, active=True):
        seen = Seen(self, si, active)
        passes = sample1 < seen.passing
        pick = (sample1 - seen.passing) / dr.maximum(1 - seen.passing, 1e-6)
        glossy = (sample1 >= seen.passing) & (pick < seen.share)
        facet = dr.select(seen.mirror, seen.normal, seen.visible_normal(sample2))
        mirrored = facet * (2 * dr.dot(seen.eye, facet)) - seen.eye
        scattered = mi.Frame3f(seen.normal).to_world(mi.warp.square_to_cosine_hemisphere(sample2))
        light = dr.select(glossy, dr.normalize(mirrored), scattered)
        value, density = seen.eval_pdf(light)
        delta = glossy & seen.mirror
        density = dr.select(delta, seen.share * (1 - seen.passing), density)
        value = dr.select(delta & seen.meets(light), seen.fresnel(seen.cosine), value)
        density = dr.select(passes, seen.passing, density)
        value = dr.select(passes, seen.passed, value)

        active = active & (density > 0)
        bs = dr.zeros(mi.BSDFSample3f)
        bs.wo = dr.select(passes, -si.wi, light)
        bs.pdf = dr.select(active, density, 0)
        bs.eta = 1.0
        smooth = dr.select(glossy, mi.UInt32(+mi.BSDFFlags.GlossyReflection), mi.UInt32(+mi.BSDFFlags.DiffuseReflection))
        kind = dr.select(delta, mi.UInt32(+mi.BSDFFlags.DeltaReflection), smooth)
        bs.sampled_type = dr.select(passes, mi.UInt32(+mi.BSDFFlags.Null), kind)
        bs.sampled_component = dr.select(passes, mi.UInt32(3), dr.select(delta, mi.UInt32(2), dr.select(glossy, mi.UInt32(1), mi.UInt32(0))))
        return bs, dr.select(active, value / dr.maximum(density, 1e-37), 0)

    def eval(self, ctx, si, wo, active=True):
        return self.eval_pdf(ctx, si, wo, active)[0]

    def pdf(self, ctx, si, wo, active=True):
        return self.eval_pdf(ctx, si, wo, active)[1]

    def eval_pdf(self, ctx, si, wo, active=True):
        value, density = Seen(self, si, active).eval_pdf(wo)
        return dr.select(active, value, 0), dr.select(active, density, 0)

    def eval_null_transmission(self, si, active=True):
        return dr.select(active, Seen(self, si, active).passed, 0)

    def to_string(self):
        return f"Glowworm[base_color={self.base_color}, metallic={self.metallic}, roughness={self.roughness}]"


mi.register_bsdf("glowworm", Glowworm)


def main():
    folder = Path(__file__).resolve().parent
    scene = mi.load_file(str(folder / "scene.xml"), materials=MATERIALS)
    picture = sys.argv[1] if len(sys.argv) > 1 else str(folder / "scene.exr")
    mi.util.write_bitmap(picture, mi.render(scene))
    print(picture)


if __name__ == "__main__":
    main()
