// Embree on the scenes and rays that `heliotile-bench --rays FOLDER` wrote: Mray/s of one thread, best of its packet and
// stream modes and its single rays. Builds with Embree 3 or 4: g++ -O3 -march=native embree.cpp -lembree3 (or 4).
#ifdef EMBREE4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <limits>
#include <vector>

struct Ray { float origin[3], direction[3]; };

static double seconds() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// Median of five runs, Mray/s.
template <class F> static double rate(size_t rays, F run) {
    double rates[5];
    for (double &r : rates) {
        double start = seconds();
        run();
        r = rays / 1e6 / (seconds() - start);
    }
    std::sort(rates, rates + 5);
    return rates[2];
}

static const float INF = std::numeric_limits<float>::infinity();

template <bool ANY, int N> static size_t packets(RTCScene scene, const std::vector<Ray> &rays, bool coherent) {
    size_t met = 0;
    alignas(64) int valid[16];
#ifdef EMBREE4
    RTCIntersectArguments closest; rtcInitIntersectArguments(&closest);
    RTCOccludedArguments any; rtcInitOccludedArguments(&any);
    closest.flags = any.flags = coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;
    RTCIntersectArguments *c = &closest; RTCOccludedArguments *a = &any;
#else
    RTCIntersectContext context; rtcInitIntersectContext(&context);
    context.flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    RTCIntersectContext *c = &context, *a = &context;
#endif
    for (size_t i = 0; i < rays.size(); i += N) {
        if (N == 16) {
            RTCRayHit16 r;
            for (int k = 0; k < 16; k++) {
                const Ray &q = rays[std::min(i + k, rays.size() - 1)];
                valid[k] = i + k < rays.size() ? -1 : 0;
                r.ray.org_x[k] = q.origin[0]; r.ray.org_y[k] = q.origin[1]; r.ray.org_z[k] = q.origin[2];
                r.ray.dir_x[k] = q.direction[0]; r.ray.dir_y[k] = q.direction[1]; r.ray.dir_z[k] = q.direction[2];
                r.ray.tnear[k] = 0; r.ray.tfar[k] = INF; r.ray.mask[k] = ~0u; r.ray.flags[k] = 0; r.ray.time[k] = 0;
                r.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
            }
#ifdef EMBREE4
            if (ANY) rtcOccluded16(valid, scene, &r.ray, a); else rtcIntersect16(valid, scene, &r, c);
#else
            if (ANY) rtcOccluded16(valid, scene, a, &r.ray); else rtcIntersect16(valid, scene, c, &r);
#endif
            for (int k = 0; k < 16; k++)
                met += valid[k] && (ANY ? r.ray.tfar[k] < 0 : r.hit.geomID[k] != RTC_INVALID_GEOMETRY_ID);
        } else {
            RTCRayHit r;
            const Ray &q = rays[i];
            r.ray.org_x = q.origin[0]; r.ray.org_y = q.origin[1]; r.ray.org_z = q.origin[2];
            r.ray.dir_x = q.direction[0]; r.ray.dir_y = q.direction[1]; r.ray.dir_z = q.direction[2];
            r.ray.tnear = 0; r.ray.tfar = INF; r.ray.mask = ~0u; r.ray.flags = 0; r.ray.time = 0;
            r.hit.geomID = RTC_INVALID_GEOMETRY_ID;
#ifdef EMBREE4
            if (ANY) rtcOccluded1(scene, &r.ray, a); else rtcIntersect1(scene, &r, c);
#else
            if (ANY) rtcOccluded1(scene, a, &r.ray); else rtcIntersect1(scene, c, &r);
#endif
            met += ANY ? r.ray.tfar < 0 : r.hit.geomID != RTC_INVALID_GEOMETRY_ID;
        }
    }
    return met;
}

int main(int argc, char **argv) {
    RTCDevice device = rtcNewDevice("threads=1");
    for (int f = 1; f < argc; f++) {
        FILE *file = fopen(argv[f], "rb");
        if (!file) { perror(argv[f]); return 2; }
        uint32_t count = 0;
        if (fread(&count, 4, 1, file) != 1) return 2;
        RTCScene scene = rtcNewScene(device);
        rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
        RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
        float *v = (float *)rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, 3 * (size_t)count);
        unsigned *t = (unsigned *)rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, count);
        if (fread(v, 36, count, file) != count) return 2;
        for (size_t i = 0; i < 3 * (size_t)count; i++) t[i] = i;
        rtcCommitGeometry(mesh); rtcAttachGeometry(scene, mesh); rtcReleaseGeometry(mesh); rtcCommitScene(scene);
        std::vector<Ray> sets[2];
        for (auto &set : sets) {
            uint32_t n = 0;
            if (fread(&n, 4, 1, file) != 1) return 2;
            set.resize(n);
            if (fread(set.data(), sizeof(Ray), n, file) != n) return 2;
        }
        fclose(file);
        const char *name = strrchr(argv[f], '/') ? strrchr(argv[f], '/') + 1 : argv[f];
        int length = (int)strcspn(name, ".");
        for (int coherent = 0; coherent < 2; coherent++) {
            size_t met = 0;
            double r[4];
            for (int s = 0; s < 2; s++) {
                r[2 * s] = rate(sets[s].size(), [&] { met = packets<true, 16>(scene, sets[s], coherent); });
                r[2 * s + 1] = rate(sets[s].size(), [&] { met = packets<false, 16>(scene, sets[s], coherent); });
                if (s == 0) met = packets<true, 16>(scene, sets[0], coherent);
            }
            met = packets<true, 16>(scene, sets[0], coherent);
            printf("| %.*s %u | Embree 16-packets%s | %.1f | %.1f | %.1f | %.1f | %.4f %% |\n", length, name, count,
                   coherent ? ", coherent" : "", r[0], r[1], r[2], r[3], 100.0 * met / sets[0].size());
        }
        double any = rate(sets[0].size(), [&] { packets<true, 1>(scene, sets[0], true); });
        double closest = rate(sets[0].size(), [&] { packets<false, 1>(scene, sets[0], true); });
        printf("| %.*s %u | Embree single | %.1f | %.1f | - | - | |\n", length, name, count, any, closest);
        fflush(stdout);
        rtcReleaseScene(scene);
    }
    rtcReleaseDevice(device);
}
