!> The table of rules: its conditions name groups, keys, choices and features that exist, no row stands twice, and what it advises is known.
program test_rules
   use hampm_choice_sets, only: expanded
   use hampm_conditions, only: atom_t, features, is_named, is_present, parse_condition
   use hampm_harness, only: check, finish
   use hampm_keys, only: keys, find_group, find_key, first_key, is_text
   use hampm_rules, only: rules, requires, no_effect_without, not_built
   implicit none
   type(atom_t), allocatable :: subject(:), other(:)
   character(:), allocatable :: text
   integer :: k

   do k = 1, size(rules)
      associate (rule => rules(k))
         text = trim(rule%subject)//' / '//trim(rule%other)
         call check(condition_mistake(trim(rule%subject)) == '', text//': '//condition_mistake(trim(rule%subject)))
         call check(condition_mistake(trim(rule%other)) == '', text//': '//condition_mistake(trim(rule%other)))
         call parse_condition(rule%subject, subject)
         call parse_condition(rule%other, other)
         call check(subject(1)%group /= '', text//': it is about a group')
         call check(all(subject%alternative == 1), text//': one condition is broken at a time')
         if (all(rule%verdict /= [requires, no_effect_without])) &
            call check(all(other%alternative == 1), text//': only what is required has alternatives')
         if (rule%use(1:1) == '&') call check(condition_mistake(trim(rule%use)) == '', text//': advice '//trim(rule%use))
         if (rule%use(1:1) == '&') call check(heals(rule%use), text//': with what is advised it is not broken')
         if (rule%basis == not_built) call check(rule%reason /= '' .or. rule%use /= '', text//': says what is not there')
         call check(len_trim(rule%reason) < len(rule%reason) .and. len_trim(rule%other) < len(rule%other) .and. &
                    len_trim(rule%subject) < len(rule%subject) .and. len_trim(rule%use) < len(rule%use), text//': is not cut off')
         call check(.not. any(rules(:k - 1)%subject == rule%subject .and. rules(:k - 1)%other == rule%other .and. &
                              rules(:k - 1)%verdict == rule%verdict), text//': stands once')
      end associate
   end do
   deallocate (subject, other, text)

   call check(condition_mistake('&method tim = ''static''') /= '', 'a key that does not exist is found')
   call check(condition_mistake('&method time = ''statik''') /= '', 'a choice that does not exist is found')
   call check(condition_mistake('&methode') /= '', 'a group that does not exist is found')
   call check(condition_mistake('cells that fly') /= '', 'a feature that does not exist is found')
   call finish()

contains

   !> What is wrong with a condition, '' for nothing: groups, keys, choices and features that are not there.
   function condition_mistake(text) result(mistake)
      character(*), intent(in) :: text
      character(:), allocatable :: mistake
      type(atom_t), allocatable :: atoms(:)
      integer :: i, k, row
      mistake = ''
      call parse_condition(text, atoms)
      do i = 1, size(atoms)
         associate (atom => atoms(i))
            if (atom%kind == is_named) then
               if (.not. any(features == atom%text)) mistake = 'no feature '//trim(atom%text)
               cycle
            end if
            if (find_group(trim(atom%group)) == 0) then
               mistake = 'no group &'//trim(atom%group)
               cycle
            end if
            if (atom%kind == is_present) cycle
            row = find_key(find_group(trim(atom%group)), trim(atom%key))
            if (row == 0 .or. atom%kind == 0) then
               mistake = 'no condition: '//trim(atom%text)
               cycle
            end if
            associate (key => keys(first_key(find_group(trim(atom%group))) + row - 1))
               do k = 1, atom%choices
                  if (key%allowed /= '' .and. is_text(key) .and. &
                      index('|'//expanded(key%allowed, '', '|')//'|', '|'//trim(atom%values(k))//'|') == 0) &
                     mistake = '&'//trim(atom%group)//' '//trim(atom%key)//' has no choice '//trim(atom%values(k))
               end do
            end associate
         end associate
      end do
   end function condition_mistake

   !> Whether an advice gives a key of the rule a value with which it is not broken.
   logical function heals(advice)
      character(*), intent(in) :: advice
      type(atom_t), allocatable :: given(:), atoms(:)
      integer :: i, j
      call parse_condition(advice, given)
      allocate (atoms, source=[subject, other])
      heals = .false.
      do i = 1, size(given)
         do j = 1, size(atoms)
            if (atoms(j)%group /= given(i)%group .or. atoms(j)%key /= given(i)%key) cycle
            heals = heals .or. index(atoms(j)%text, ' < ') > 0 .or. &
                    .not. any(atoms(j)%values(:atoms(j)%choices) == given(i)%values(1))
         end do
      end do
   end function heals
end program test_rules
