#version 460
// Automatic exposure: the log-average luminance, without the darkest and brightest tenth of the
// picture, becomes middle grey (Reinhard et al. 2002); at once, or frame by frame.

layout(local_size_x = 1) in;

layout(set = 0, binding = 0, std430) readonly buffer HistogramBlock { uint bins[256]; } histogram;
layout(set = 0, binding = 1, std430) buffer ExposureBlock { float factor; } exposure;

layout(push_constant) uniform Push { float stops; uint automatic; float pace; } push;

const float MIDDLE_GREY = 0.18;
// Stops that nobody sees: the last step goes all the way, so that a picture comes to rest.
const float UNSEEN = 0.02;

void main() {
    if (push.automatic == 0u) {
        exposure.factor = exp2(push.stops);
        return;
    }
    float total = 0.0;
    for (uint i = 0u; i < 256u; i++) total += float(histogram.bins[i]);
    float low = 0.1 * total;
    float high = 0.9 * total;
    float seen = 0.0;
    float sum = 0.0;
    float weight = 0.0;
    for (uint i = 0u; i < 256u; i++) {
        float count = float(histogram.bins[i]);
        float kept = max(min(seen + count, high) - max(seen, low), 0.0);
        sum += kept * (float(i) + 0.5 - 128.0) / 8.0;
        weight += kept;
        seen += count;
    }
    float target = weight > 0.0 ? MIDDLE_GREY / exp2(sum / weight) : 1.0;
    float before = exposure.factor;
    float way = log2(target / before);
    exposure.factor = push.pace >= 1.0 || abs(way) < UNSEEN ? target : before * exp2(push.pace * way);
}
