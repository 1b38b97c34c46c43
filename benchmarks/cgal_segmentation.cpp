// The parts that CGAL finds on a closed triangle mesh by its shape diameters, so that they can be measured beside lbskel's.
//
// cgal_segmentation IN.off OUT.txt
//
// Shapira, Shamir, Cohen-Or 2008, https://doi.org/10.1007/s00371-007-0197-5, with CGAL's own defaults. OUT.txt gets the
// processor's seconds, and the part of each face.

#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/mesh_segmentation.h>

#include <cstdio>
#include <ctime>
#include <exception>
#include <fstream>
#include <iostream>

using Kernel = CGAL::Simple_cartesian<double>;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;

static int measure(const char* from, const char* to) {
    Mesh mesh;
    std::ifstream input(from);
    if (!(input >> mesh) || !CGAL::is_triangle_mesh(mesh)) {
        std::cerr << "CGAL needs a triangle mesh\n";
        return 1;
    }
    const std::clock_t start = std::clock();
    auto diameters = mesh.add_property_map<Mesh::Face_index, double>("f:sdf", 0.0).first;
    auto parts = mesh.add_property_map<Mesh::Face_index, std::size_t>("f:part", 0).first;
    CGAL::sdf_values(mesh, diameters);
    CGAL::segmentation_from_sdf_values(mesh, diameters, parts);
    const double seconds = double(std::clock() - start) / CLOCKS_PER_SEC;
    std::FILE* output = std::fopen(to, "w");
    if (!output) {
        std::cerr << "cannot write " << to << "\n";
        return 1;
    }
    std::fprintf(output, "%.6f\n", seconds);
    for (const auto face : mesh.faces()) std::fprintf(output, "%zu\n", parts[face]);
    return std::fclose(output) ? 1 : 0;
}

int main(int count, char** arguments) {
    if (count != 3) {
        std::cerr << "usage: cgal_segmentation IN.off OUT.txt\n";
        return 2;
    }
    try {
        return measure(arguments[1], arguments[2]);
    } catch (const std::exception& error) {
        std::cerr << error.what() << "\n";
        return 1;
    }
}
