!> The number kinds and the dimension that every other module counts in.
module hampm_kinds
   use, intrinsic :: iso_fortran_env, only: real64, int64
   implicit none
   private
   public :: dp, long, ndim, plane, corners, neighbours, name_len, path_len

   integer, parameter :: dp = real64     !! kind of every real number
   integer, parameter :: long = int64    !! kind of counters that outgrow 2**31
   integer, parameter :: ndim = DIMENSIONS !! of space: 2 or, in the build for solids, 3
   integer, parameter :: plane = 2       !! dimensions of a plane, for parts that only plane models have
   integer, parameter :: corners = 2**ndim !! corners of a cell
   integer, parameter :: neighbours = 3**ndim !! nodes of the cells around a node, where all have the same size and no cut ends
   integer, parameter :: name_len = 64   !! longest name or keyword in an input file
   integer, parameter :: path_len = 1024 !! longest path of a file
end module hampm_kinds
