!> The table of rules: its values are choices that exist, no row stands twice, and what it advises heals it. That groups, keys and features of
!> conditions exist is looked at where the table is written (tools/schema.py).
program test_rules
   use hampm_choice_sets, only: expanded, is_among
   use hampm_harness, only: check, finish
   use hampm_keys, only: choices, first_key, is_text, keys
   use hampm_kinds, only: name_len
   use hampm_rule_table, only: atoms, features, rules, values
   use hampm_rules, only: is_below, is_named, no_effect_without, not_built, requires
   implicit none
   character(:), allocatable :: text
   integer :: k, i, used(size(features))
   character(*), parameter :: may_be_empty = '{estimators of isotropic material}' !! a worked example has one

   used = 0
   do k = 1, size(rules)
      associate (rule => rules(k))
         text = trim(rule%subject)//' / '//trim(rule%other)
         call check(atoms(rule%behind + 1)%group > 0, text//': it is about a group')
         do i = rule%behind + 1, rule%behind + rule%of_subject + rule%of_other + rule%of_use
            call check(has_choices(i), text//': its choices exist')
            if (atoms(i)%kind == is_named) used(atoms(i)%feature) = used(atoms(i)%feature) + 1
         end do
         associate (other => atoms(rule%behind + rule%of_subject + 1:rule%behind + rule%of_subject + rule%of_other))
            if (all(rule%verdict /= [requires, no_effect_without])) &
               call check(all(other%alternative == 1), text//': only what is required has alternatives')
         end associate
         if (rule%use(1:1) == '&') call check(heals(k), text//': with what is advised it is not broken')
         if (rule%basis == not_built) call check(rule%reason /= '' .or. rule%use /= '', text//': says what is not there')
         call check(len_trim(rule%reason) < len(rule%reason) .and. len_trim(rule%other) < len(rule%other) .and. &
                    len_trim(rule%subject) < len(rule%subject) .and. len_trim(rule%use) < len(rule%use), text//': is not cut off')
         call check(.not. any(rules(:k - 1)%subject == rule%subject .and. rules(:k - 1)%other == rule%other .and. &
                              rules(:k - 1)%verdict == rule%verdict), text//': stands once')
      end associate
   end do
   do k = 1, size(features)
      call check(used(k) > 0, trim(features(k))//' is a feature that a rule names')
   end do
   call check(is_among('j2_plastic', [character(name_len) :: 'none', '{laws with a history}']) .and. &
              .not. is_among('orthotropic', [character(name_len) :: 'none', '{laws with a history}']), 'sets have their names')
   call finish()

contains

   !> Whether the values of a word are among the choices of its key, and sets have names.
   logical function has_choices(word) result(has)
      integer, intent(in) :: word
      character(name_len), allocatable :: list(:)
      integer :: i
      has = .true.
      if (atoms(word)%last < atoms(word)%first) return
      associate (key => keys(first_key(atoms(word)%group) + atoms(word)%key - 1))
         if (key%allowed == '' .or. .not. is_text(key)) return
         call choices(key, list)
         do i = atoms(word)%first, atoms(word)%last
            if (values(i)(1:1) == '{') then
               has = has .and. (expanded(values(i), '', '|') /= '' .or. values(i) == may_be_empty)
            else
               has = has .and. any(list == values(i))
            end if
         end do
      end associate
   end function has_choices

   !> Whether an advice gives a key of the rule a value with which it is not broken.
   logical function heals(row)
      integer, intent(in) :: row
      integer :: i, j, behind
      heals = .false.
      associate (rule => rules(row))
         behind = rule%behind + rule%of_subject + rule%of_other
         do i = behind + 1, behind + rule%of_use
            do j = rule%behind + 1, behind
               if (atoms(j)%group /= atoms(i)%group .or. atoms(j)%key /= atoms(i)%key) cycle
               heals = heals .or. atoms(j)%kind == is_below
               if (atoms(i)%last >= atoms(i)%first) then
                  heals = heals .or. .not. any(values(atoms(j)%first:atoms(j)%last) == values(atoms(i)%first))
               else
                  heals = heals .or. abs(atoms(j)%number - atoms(i)%number) > 0
               end if
            end do
         end do
      end associate
   end function heals
end program test_rules
