!> Snapshots of the run in the result file, as ParaView opens them: a VTKHDF time series of several pieces, which VTK calls blocks
!> too, each an unstructured grid whose numbers of points and cells may change from snapshot to snapshot.
!>
!> Layout: /VTKHDF/<piece> holds the data of all snapshots one after the other, /VTKHDF/<piece>/Steps where each
!> snapshot begins, and /VTKHDF/Assembly the tree of pieces. Nothing is made before the first snapshot.
!>
!> VTK from 9.6.2 on reads the number of snapshots from /VTKHDF/Steps and takes it for one more piece, as older versions do. It is a
!> link to the first piece, which therefore has NSteps and Values, as both need.
module hampm_snapshots
   use hampm_kinds, only: dp, long, ndim
   use hampm_failure, only: failure_t
   use hampm_hdf5_file, only: hdf5_file_t
   use hampm_hdf5_series, only: hdf5_series_t, real_values, long_values, byte_values
   implicit none
   private
   public :: snapshots_t, piece_t, field_t, add_field, vtk_vertex, vtk_line, vtk_polygon, vtk_quad, vtk_hexahedron, &
             vtk_biquadratic_quad

   integer, parameter :: vtk_vertex = 1, vtk_line = 3, vtk_polygon = 7, vtk_quad = 9, vtk_hexahedron = 12, vtk_biquadratic_quad = 28
                         !! VTK's numbers of the types of cells
   integer, parameter :: vtk_dim = 3            !! components of a point or vector in VTK
   integer, parameter :: format_version(2) = [2, 2] !! of VTKHDF
   character(*), parameter :: root = '/VTKHDF'

   !> A field on the points or cells of a piece.
   type :: field_t
      character(:), allocatable :: name, unit    !! SI unit, '1' for a pure number
      real(dp), allocatable :: values(:, :)      !! shape (k, n); k = ndim is a vector, completed with zeros
   end type field_t

   !> A set of points, of cells between them, and fields on both.
   type :: piece_t
      character(:), allocatable :: name          !! such as 'particles' or 'mesh': letters, digits and _ only
      real(dp), allocatable :: points(:, :)      !! positions [m], shape (ndim, points)
      integer, allocatable :: connectivity(:)    !! the points of all cells, counted from 0
      integer, allocatable :: offsets(:)         !! where each cell begins there, and where the last ends; (cells + 1)
      integer, allocatable :: cell_types(:)      !! type of each cell, VTK's number, shape (cells)
      type(field_t), allocatable :: point_fields(:), cell_fields(:)
   contains
      procedure :: set_vertices
   end type piece_t

   ! The growing datasets of a piece
   integer, parameter :: points = 1, connectivity = 2, offsets = 3, types = 4
   integer, parameter :: point_number = 5, cell_number = 6, connectivity_number = 7
   integer, parameter :: times = 8, first_part = 9, first_point = 10, first_cell = 11, first_connectivity = 12
   integer, parameter :: fields = 12             !! those behind are of the fields, of the points first
   character(*), parameter :: names(fields) = [character(27) :: 'Points', 'Connectivity', 'Offsets', 'Types', 'NumberOfPoints', &
      'NumberOfCells', 'NumberOfConnectivityIds', 'Steps/Values', 'Steps/PartOffsets', 'Steps/PointOffsets', &
      'Steps/CellOffsets', 'Steps/ConnectivityIdOffsets']
   integer, parameter :: stored(fields) = [real_values, long_values, long_values, byte_values, long_values, long_values, &
                                           long_values, real_values, long_values, long_values, long_values, long_values]

   !> The growing datasets of all pieces, of each in the order above.
   type :: snapshots_t
      private
      type(hdf5_series_t), allocatable :: series(:)
      integer, allocatable :: first(:)           !! start of each piece, and end of the last
      integer(long), allocatable :: kept(:)      !! entries of each dataset that are kept where a file is continued
   contains
      procedure :: write => write_snapshot
      procedure :: lengths
      procedure :: keep_only
      procedure :: reopen
      procedure :: can_catch_up
      procedure :: catch_up
   end type snapshots_t

contains

   !> Make the piece a cloud of points, one cell each.
   subroutine set_vertices(self, name, points)
      class(piece_t), intent(inout) :: self
      character(*), intent(in) :: name
      real(dp), intent(in) :: points(:, :)       !! positions [m], shape (ndim, n)
      integer :: i
      self%name = name
      self%points = points
      self%offsets = [(i, i=0, size(points, 2))]
      self%connectivity = self%offsets(:size(points, 2))
      self%cell_types = spread(vtk_vertex, 1, size(points, 2))
   end subroutine set_vertices

   !> Add a field to those on the points or cells of a piece.
   subroutine add_field(fields, name, values, unit)
      type(field_t), allocatable, intent(inout) :: fields(:)
      character(*), intent(in) :: name
      real(dp), intent(in) :: values(:, :)       !! shape (k, points) or (k, cells)
      character(*), intent(in), optional :: unit !! SI unit; a pure number where it is absent
      type(field_t), allocatable :: longer(:)
      integer :: i, n
      n = 0
      if (allocated(fields)) n = size(fields)
      allocate (longer(n + 1))
      do i = 1, n
         call move_alloc(fields(i)%name, longer(i)%name)
         call move_alloc(fields(i)%unit, longer(i)%unit)
         call move_alloc(fields(i)%values, longer(i)%values)
      end do
      longer(n + 1)%name = name
      longer(n + 1)%unit = '1'
      if (present(unit)) longer(n + 1)%unit = unit
      longer(n + 1)%values = values
      call move_alloc(longer, fields)
   end subroutine add_field

   !> Append a snapshot. The first one fixes the pieces and the names and components of their fields.
   subroutine write_snapshot(self, file, time, pieces, failure)
      class(snapshots_t), intent(inout) :: self
      type(hdf5_file_t), intent(in) :: file
      real(dp), intent(in) :: time               !! [s]
      type(piece_t), intent(in) :: pieces(:)
      type(failure_t), intent(inout) :: failure
      integer :: i
      if (.not. allocated(self%series)) then
         call create_pieces(self, file, pieces, failure)
         if (.not. failure%failed()) call shorten(self, file, failure)
      end if
      do i = 1, size(pieces)
         if (failure%failed()) return
         associate (series => self%series(self%first(i):self%first(i + 1) - 1))
            call append_step(series, file, time, pieces(i), failure)
            call append_piece(series, file, pieces(i), failure)
            call note_steps(series(times), file, failure)
         end associate
      end do
   end subroutine write_snapshot

   !> Tell VTK how many snapshots there are, at the piece and at its steps.
   subroutine note_steps(series, file, failure)
      type(hdf5_series_t), intent(in) :: series  !! the times
      type(hdf5_file_t), intent(in) :: file
      type(failure_t), intent(inout) :: failure
      character(:), allocatable :: steps
      steps = folder_of(series%path)
      call file%put_attribute(steps, 'NSteps', int(series%length), failure)
      call file%put_attribute(folder_of(steps), 'NSteps', int(series%length), failure)
   end subroutine note_steps

   !> Number of entries of each dataset, or the number to be kept where the file is continued and not yet shortened.
   function lengths(self)
      class(snapshots_t), intent(in) :: self
      integer(long), allocatable :: lengths(:)
      allocate (lengths(0))
      if (allocated(self%kept)) lengths = self%kept
      if (allocated(self%series)) lengths = self%series%length
   end function lengths

   !> Where a file is continued: drop all entries beyond these lengths before the next snapshot is written.
   subroutine keep_only(self, lengths)
      class(snapshots_t), intent(inout) :: self
      integer(long), intent(in) :: lengths(:)
      self%kept = lengths
   end subroutine keep_only

   !> Shorten all datasets to the entries to be kept.
   subroutine shorten(self, file, failure)
      type(snapshots_t), intent(inout) :: self
      type(hdf5_file_t), intent(in) :: file
      type(failure_t), intent(inout) :: failure
      integer(long) :: length
      integer :: k
      if (.not. allocated(self%kept)) return
      do k = 1, size(self%series)
         length = 0
         if (k <= size(self%kept)) length = self%kept(k)
         call self%series(k)%shorten(file, length, failure)
      end do
   end subroutine shorten

   !> Find all datasets again in a file that has been opened anew.
   subroutine reopen(self, file, failure)
      class(snapshots_t), intent(inout) :: self
      type(hdf5_file_t), intent(in) :: file
      type(failure_t), intent(inout) :: failure
      integer :: k
      if (.not. allocated(self%series)) return
      do k = 1, size(self%series)
         if (.not. failure%failed()) call self%series(k)%reopen(file, failure)
      end do
   end subroutine reopen

   !> Whether an earlier state of the file has all datasets.
   logical function can_catch_up(self, file)
      class(snapshots_t), intent(in) :: self
      type(hdf5_file_t), intent(in) :: file
      can_catch_up = .not. allocated(self%series)
      if (.not. can_catch_up) can_catch_up = file%holds(root)
   end function can_catch_up

   !> Append the further entries of the donor, a later state of the file.
   subroutine catch_up(self, file, donor, failure)
      class(snapshots_t), intent(inout) :: self
      type(hdf5_file_t), intent(in) :: file, donor
      type(failure_t), intent(inout) :: failure
      integer :: k
      if (.not. allocated(self%series)) return
      do k = 1, size(self%series)
         if (.not. failure%failed()) call self%series(k)%catch_up(file, donor, failure)
      end do
      do k = 1, size(self%first) - 1
         if (.not. failure%failed()) call note_steps(self%series(self%first(k) - 1 + times), file, failure)
      end do
   end subroutine catch_up

   !> Make the groups and the empty datasets of all pieces, and the tree that names them.
   subroutine create_pieces(self, file, pieces, failure)
      class(snapshots_t), intent(inout) :: self
      type(hdf5_file_t), intent(in) :: file
      type(piece_t), intent(in) :: pieces(:)
      type(failure_t), intent(inout) :: failure
      integer :: i
      self%first = [1]
      do i = 1, size(pieces)
         self%first = [self%first, self%first(i) + fields + field_count(pieces(i)%point_fields) + &
                       field_count(pieces(i)%cell_fields)]
      end do
      allocate (self%series(self%first(size(self%first)) - 1))
      call make_typed_group(file, root, 'MultiBlockDataSet', failure)
      do i = 1, size(pieces)
         call make_typed_group(file, piece_path(pieces(i)), 'UnstructuredGrid', failure)
         call file%put_attribute(piece_path(pieces(i)), 'Index', i - 1, failure)
         associate (series => self%series(self%first(i):self%first(i + 1) - 1), &
                    first_of_cells => fields + field_count(pieces(i)%point_fields) + 1)
            call create_datasets(series, file, pieces(i), failure)
            call create_fields(series(fields + 1:first_of_cells - 1), file, pieces(i), 'Point', pieces(i)%point_fields, failure)
            call create_fields(series(first_of_cells:), file, pieces(i), 'Cell', pieces(i)%cell_fields, failure)
         end associate
      end do
      call create_assembly(file, pieces, failure)
   end subroutine create_pieces

   !> Number of the fields in a list.
   pure integer function field_count(list)
      type(field_t), allocatable, intent(in) :: list(:)
      field_count = 0
      if (allocated(list)) field_count = size(list)
   end function field_count

   !> Make a group that VTK recognises.
   subroutine make_typed_group(file, path, type_name, failure)
      type(hdf5_file_t), intent(in) :: file
      character(*), intent(in) :: path, type_name
      type(failure_t), intent(inout) :: failure
      call file%make_group(path, failure)
      call file%put_label(path, 'Type', type_name, failure)
      call file%put_attribute(path, 'Version', format_version, failure)
   end subroutine make_typed_group

   !> Make the tree of pieces, a link a piece, and the piece that tells VTK the times of all.
   subroutine create_assembly(file, pieces, failure)
      type(hdf5_file_t), intent(in) :: file
      type(piece_t), intent(in) :: pieces(:)
      type(failure_t), intent(inout) :: failure
      integer :: i
      call file%make_group(root//'/Assembly', failure)
      do i = 1, size(pieces)
         call file%make_link(piece_path(pieces(i)), root//'/Assembly/'//pieces(i)%name, failure)
         call file%make_link(steps_path(pieces(i))//'/Values', piece_path(pieces(i))//'/Values', failure)
      end do
      call file%make_link(piece_path(pieces(1)), root//'/Steps', failure)
   end subroutine create_assembly

   !> Make the datasets of points and cells, and those that say where each snapshot begins.
   subroutine create_datasets(series, file, piece, failure)
      type(hdf5_series_t), intent(inout) :: series(:)
      type(hdf5_file_t), intent(in) :: file
      type(piece_t), intent(in) :: piece
      type(failure_t), intent(inout) :: failure
      integer :: entries(fields), k
      entries = 1
      entries(:types) = [size(piece%points, 2), size(piece%connectivity), size(piece%cell_types), size(piece%cell_types)]
      do k = 1, fields
         if (k == times) call file%make_group(steps_path(piece), failure)
         call series(k)%create(file, piece_path(piece)//'/'//trim(names(k)), stored(k), merge(vtk_dim, 1, k == points), &
                                  chunk(entries(k)), failure)
      end do
   end subroutine create_datasets

   !> Make the datasets of the fields on the points or cells. They begin where the points or cells begin.
   subroutine create_fields(series, file, piece, carrier, fields, failure)
      type(hdf5_series_t), intent(inout) :: series(:)
      type(hdf5_file_t), intent(in) :: file
      type(piece_t), intent(in) :: piece
      character(*), intent(in) :: carrier        !! 'Point' or 'Cell'
      type(field_t), allocatable, intent(in) :: fields(:)
      type(failure_t), intent(inout) :: failure
      character(:), allocatable :: data_path, first_path
      integer :: i, rows
      if (.not. allocated(fields)) return
      data_path = piece_path(piece)//'/'//carrier//'Data'
      first_path = steps_path(piece)//'/'//carrier//'DataOffsets'
      call file%make_group(data_path, failure)
      call file%make_group(first_path, failure)
      do i = 1, size(fields)
         rows = size(fields(i)%values, 1)
         if (rows == ndim) rows = vtk_dim
         call series(i)%create(file, data_path//'/'//fields(i)%name, real_values, rows, &
                               chunk(size(fields(i)%values, 2)), failure)
         call file%put_attribute(data_path//'/'//fields(i)%name, 'units', fields(i)%unit, failure)
         call file%make_link(steps_path(piece)//'/'//carrier//'Offsets', first_path//'/'//fields(i)%name, failure)
      end do
   end subroutine create_fields

   !> Note when the snapshot is, where its data begin, and how many they are. Offsets hold one entry more than cells
   !> for each snapshot, which VTK accounts for itself.
   subroutine append_step(series, file, time, piece, failure)
      type(hdf5_series_t), intent(inout) :: series(:)
      type(hdf5_file_t), intent(in) :: file
      real(dp), intent(in) :: time
      type(piece_t), intent(in) :: piece
      type(failure_t), intent(inout) :: failure
      call series(first_part)%append(file, [series(first_part)%length], failure)
      call series(first_point)%append(file, [series(points)%length], failure)
      call series(first_cell)%append(file, [series(types)%length], failure)
      call series(first_connectivity)%append(file, [series(connectivity)%length], failure)
      call series(point_number)%append(file, [size(piece%points, 2)], failure)
      call series(cell_number)%append(file, [size(piece%cell_types)], failure)
      call series(connectivity_number)%append(file, [size(piece%connectivity)], failure)
      call series(times)%append(file, [time], failure)
   end subroutine append_step

   !> Append the points, cells and fields of a piece.
   subroutine append_piece(series, file, piece, failure)
      type(hdf5_series_t), intent(inout) :: series(:)
      type(hdf5_file_t), intent(in) :: file
      type(piece_t), intent(in) :: piece
      type(failure_t), intent(inout) :: failure
      call series(points)%append(file, completed(piece%points), failure)
      call series(connectivity)%append(file, piece%connectivity, failure)
      call series(offsets)%append(file, piece%offsets, failure)
      call series(types)%append(file, piece%cell_types, failure)
      associate (first_of_cells => fields + field_count(piece%point_fields) + 1)
         if (allocated(piece%point_fields)) call append_fields(series(fields + 1:first_of_cells - 1), file, &
                                                               piece%point_fields, failure)
         if (allocated(piece%cell_fields)) call append_fields(series(first_of_cells:), file, piece%cell_fields, failure)
      end associate
   end subroutine append_piece

   !> Append fields, in the order of the first snapshot.
   subroutine append_fields(series, file, fields, failure)
      type(hdf5_series_t), intent(inout) :: series(:)
      type(hdf5_file_t), intent(in) :: file
      type(field_t), intent(in) :: fields(:)
      type(failure_t), intent(inout) :: failure
      integer :: i
      do i = 1, size(series)
         if (size(fields(i)%values, 1) == ndim) then
            call series(i)%append(file, completed(fields(i)%values), failure)
         else
            call series(i)%append(file, fields(i)%values, failure)
         end if
      end do
   end subroutine append_fields

   !> Vectors completed with zeros to VTK's three components.
   pure function completed(vectors)
      real(dp), intent(in) :: vectors(:, :)      !! shape (ndim, n)
      real(dp), allocatable :: completed(:, :)   !! shape (3, n)
      allocate (completed(vtk_dim, size(vectors, 2)))
      completed(:ndim, :) = vectors
      completed(ndim + 1:, :) = 0.0_dp
   end function completed

   !> Entries of a dataset stored together, where a snapshot has n: neither many small chunks nor a mostly empty one.
   pure integer function chunk(n)
      integer, intent(in) :: n
      chunk = max(64, min(n, 16384))
   end function chunk

   !> Path of the group that holds this path.
   pure function folder_of(path) result(folder)
      character(*), intent(in) :: path
      character(:), allocatable :: folder
      folder = path(:index(path, '/', back=.true.) - 1)
   end function folder_of

   !> Path of the group of a piece.
   pure function piece_path(piece) result(path)
      type(piece_t), intent(in) :: piece
      character(:), allocatable :: path
      path = root//'/'//piece%name
   end function piece_path

   !> Path of the group that says where each snapshot of a piece begins.
   pure function steps_path(piece) result(path)
      type(piece_t), intent(in) :: piece
      character(:), allocatable :: path
      path = piece_path(piece)//'/Steps'
   end function steps_path
end module hampm_snapshots
