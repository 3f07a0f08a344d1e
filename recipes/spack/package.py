"""The package of hampm for Spack. In a repository of your own (`spack repo create NAME`) as packages/hampm/package.py, with the sources as they
are in a folder: `spack dev-build hampm@2.0.0` there."""

from spack.package import *


class Hampm(MakefilePackage):
    """Dynamic energy release rates of cracks by a hierarchical, adaptive material point method."""

    license("MIT")

    version("2.0.0")

    variant("python", default=True, description="Scripts that draw and tabulate results")

    depends_on("fortran", type="build")
    depends_on("c", type="build")
    depends_on("gmake", type="build")
    depends_on("python@3.10:", type="build")
    depends_on("blas")
    depends_on("lapack")
    depends_on("suite-sparse")
    depends_on("arpack-ng~mpi")
    depends_on("hdf5+hl~mpi")
    depends_on("python@3.10:", type="run", when="+python")
    depends_on("py-numpy", type="run", when="+python")
    depends_on("py-h5py", type="run", when="+python")
    depends_on("py-matplotlib", type="run", when="+python")
    depends_on("py-f90nml", type="run", when="+python")

    def edit(self, spec, prefix):
        """What is linked, from Spack's own folders."""
        algebra = spec["suite-sparse"].libs + spec["arpack-ng"].libs + spec["lapack"].libs + spec["blas"].libs
        self.linked = [f"HDF5_LINK={spec['hdf5'].libs.ld_flags}", f"ALGEBRA_LINK={algebra.ld_flags}", "FC=gfortran"]

    def build(self, spec, prefix):
        make("program", *self.linked)
        make("program", "dim=3", *self.linked)

    def install(self, spec, prefix):
        """Python comes from Spack; what is built already is not built again."""
        filter_file("@tools/setup.sh program", "", "Makefile", string=True)
        make("install", "dim=3", f"PREFIX={prefix}", "packages=none", *self.linked)
