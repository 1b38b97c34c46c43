// The skeleton that CGAL makes of a closed triangle mesh, so that it can be measured beside lbskel's.
//
// cgal_skeleton IN.off OUT.txt medial|plain
//
// Mean curvature skeletons, Tagliasacchi, Alhashim, Olson, Zhang 2012, https://doi.org/10.1111/j.1467-8659.2012.03178.x,
// with CGAL's own defaults; "plain" leaves the poles out. OUT.txt gets the processor's seconds of reading and of all
// after it and the megabytes of memory at most, the number of nodes and of edges, the nodes, and the edges.

#include <CGAL/Mean_curvature_flow_skeletonization.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>

#include <cmath>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <exception>
#include <fstream>
#include <iostream>
#include <string>

using Kernel = CGAL::Simple_cartesian<double>;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;
using Flow = CGAL::Mean_curvature_flow_skeletonization<Mesh>;

static double now() { return double(std::clock()) / CLOCKS_PER_SEC; }

// Where the system does not tell, not a number.
static double peak_megabytes() {
    std::ifstream status("/proc/self/status");
    for (std::string word; status >> word;) {
        double kilobytes;
        if (word == "VmHWM:" && status >> kilobytes) return kilobytes * 1024 / 1e6;
    }
    return std::nan("");
}

static int measure(const char* from, const char* to, bool is_medial) {
    const double start = now();
    Mesh mesh;
    std::ifstream input(from);
    if (!(input >> mesh) || !CGAL::is_triangle_mesh(mesh) || !CGAL::is_closed(mesh)) {
        std::cerr << "CGAL needs a closed triangle mesh\n";
        return 1;
    }
    const double read = now();
    Flow flow(mesh);
    flow.set_is_medially_centered(is_medial);
    Flow::Skeleton skeleton;
    flow(skeleton);
    const double done = now();

    std::FILE* output = std::fopen(to, "w");
    if (!output) {
        std::cerr << "cannot write " << to << "\n";
        return 1;
    }
    std::fprintf(output, "%.6f %.6f %.1f\n", read - start, done - read, peak_megabytes());
    std::fprintf(output, "%zu %zu\n", num_vertices(skeleton), num_edges(skeleton));
    for (const auto node : CGAL::make_range(vertices(skeleton))) {
        const auto& p = skeleton[node].point;
        std::fprintf(output, "%.17g %.17g %.17g\n", p.x(), p.y(), p.z());
    }
    for (const auto edge : CGAL::make_range(edges(skeleton)))
        std::fprintf(output, "%zu %zu\n", std::size_t(source(edge, skeleton)), std::size_t(target(edge, skeleton)));
    return std::fclose(output) == 0 ? 0 : 1;
}

int main(int argc, char** argv) {
    if (argc != 4) {
        std::cerr << "usage: cgal_skeleton IN.off OUT.txt medial|plain\n";
        return 2;
    }
    try {
        return measure(argv[1], argv[2], std::strcmp(argv[3], "medial") == 0);
    } catch (const std::exception& error) {
        std::cerr << error.what() << "\n";
        return 1;
    }
}
