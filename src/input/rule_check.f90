!> Check of a model by the table of rules (`hampm_rule_table`): errors, warnings and notes.
module hampm_rule_check
   use hampm_choice_sets, only: expanded
   use hampm_conditions, only: holds, shown_atom
   use hampm_rule_table, only: atoms, rules, values
   use hampm_rules, only: atom_t, rule_t, not_with, requires, no_effect_without, noted_with
   use hampm_model, only: model_t, fill_model
   use hampm_settings, only: settings_t, setting_t
   use hampm_keys, only: keys, first_key
   use hampm_text, only: add_line
   implicit none
   private
   public :: check_rules, required_text, with_or, words

   !> Of each verdict, between its conditions
   character(*), parameter :: words(*) = [character(24) :: 'is not allowed with', 'requires', 'has no effect with', &
                                          'has no effect without', 'with', 'with']
   integer, parameter :: nowhere = -1            !! no group meets a condition
   integer, parameter :: most_advice = 10        !! messages whose advice is tried; each is a model of its own

   !> The words of the conditions of a rule, and where groups meet those that are not about the group of the message.
   type :: reading_t
      type(atom_t), allocatable :: atoms(:)      !! of the first condition, whose alternative is 0, and then of the other
      integer :: first = 0                       !! number of words of the first condition
      integer, allocatable :: met_by(:)          !! group that meets each word, or `nowhere`
      logical, allocatable :: everywhere(:)      !! whether all groups of its name meet it, and there is one
   end type reading_t

   !> A place where a rule is broken.
   type :: breach_t
      integer :: rule = 0
      integer :: entry = 0                       !! position of the group
   end type breach_t

contains

   !> Find all rules that a model breaks. Keys with errors are marked as wrong, so that other checks skip them.
   pure subroutine check_rules(model, settings, warnings, notes)
      type(model_t), intent(in) :: model
      type(settings_t), intent(inout) :: settings
      character(:), allocatable, intent(inout) :: warnings, notes !! a line each
      type(breach_t), allocatable :: breaches(:)
      type(reading_t) :: reading
      character(:), allocatable :: message
      logical :: broken(size(rules))
      integer :: k
      call find_breaches(model, settings, breaches)
      message = ''
      broken = .false.
      broken(breaches%rule) = .true.
      do k = 1, size(breaches)
         associate (rule => rules(breaches(k)%rule))
            call read_rule(rule, model, settings, reading)
            message = message_of(rule, reading, settings, breaches(k)%entry)
            if (rule%use /= '' .and. k <= most_advice) then
               if (is_allowed(rule, breaches(k)%entry, settings, broken)) &
                  message = message//'; use '//trim(rule%use)
            end if
            select case (rule%verdict)
             case (not_with, requires)
               call settings%complain_in_words(breaches(k)%entry, key_of(reading%atoms(1)), message)
             case (noted_with)
               call add_line(notes, message)
             case default
               call add_line(warnings, message)
            end select
         end associate
      end do
      do k = 1, size(breaches)
         associate (rule => rules(breaches(k)%rule), group => settings%entries(breaches(k)%entry))
            if (any(rule%verdict == [not_with, requires]) .and. atoms(rule%behind + 1)%key > 0) &
               group%settings(atoms(rule%behind + 1)%key)%good = .false.
         end associate
      end do
   end subroutine check_rules

   !> All places where a rule is broken.
   pure subroutine find_breaches(model, settings, breaches)
      type(model_t), intent(in) :: model
      type(settings_t), intent(in) :: settings
      type(breach_t), allocatable, intent(out) :: breaches(:)
      type(reading_t) :: reading
      integer :: k, entry
      allocate (breaches(0))
      do k = 1, size(rules)
         do entry = 1, settings%count
            if (holds(atoms(rules(k)%behind + 1), model, settings, entry)) exit
         end do
         if (entry > settings%count) cycle
         call read_rule(rules(k), model, settings, reading)
         associate (group => reading%atoms(1)%group)
            do entry = 1, settings%count
               if (settings%entries(entry)%group /= group) cycle
               if (any(reading%atoms%group /= group .and. reading%atoms%group /= 0)) then
                  if (.not. counts(model, settings, entry)) cycle
               end if
               if (is_broken(rules(k), reading, model, settings, entry)) breaches = [breaches, breach_t(k, entry)]
            end do
         end associate
      end do
   end subroutine find_breaches

   !> Read the words of a rule; those not about the group of its message are evaluated once.
   pure subroutine read_rule(rule, model, settings, reading)
      type(rule_t), intent(in) :: rule
      type(model_t), intent(in) :: model
      type(settings_t), intent(in) :: settings
      type(reading_t), intent(out) :: reading
      integer :: i, entry
      logical :: fits
      reading%atoms = atoms(rule%behind + 1:rule%behind + rule%of_subject + rule%of_other)
      reading%first = rule%of_subject
      allocate (reading%met_by(size(reading%atoms)), source=nowhere)
      allocate (reading%everywhere(size(reading%atoms)), source=.false.)
      do i = 1, size(reading%atoms)
         associate (atom => reading%atoms(i))
            if (atom%group == reading%atoms(1)%group .or. atom%group == 0) cycle
            reading%everywhere(i) = any(settings%entries(:settings%count)%group == atom%group)
            do entry = 1, settings%count
               if (settings%entries(entry)%group /= atom%group) cycle
               if (.not. counts(model, settings, entry)) cycle
               fits = all_of_group(reading%atoms, atom, model, settings, entry)
               reading%everywhere(i) = reading%everywhere(i) .and. fits
               if (fits .and. reading%met_by(i) == nowhere) reading%met_by(i) = entry
            end do
         end associate
      end do
   end subroutine read_rule

   !> Whether a group meets all words about it that stand together with one of them.
   pure logical function all_of_group(atoms, atom, model, settings, entry)
      type(atom_t), intent(in) :: atoms(:), atom
      type(model_t), intent(in) :: model
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: entry
      integer :: i
      all_of_group = .true.
      do i = 1, size(atoms)
         if (atoms(i)%group /= atom%group .or. atoms(i)%alternative /= atom%alternative) cycle
         all_of_group = all_of_group .and. holds(atoms(i), model, settings, entry)
      end do
   end function all_of_group

   !> Whether a rule is broken by a group, or by the model.
   pure logical function is_broken(rule, reading, model, settings, entry)
      type(rule_t), intent(in) :: rule
      type(reading_t), intent(in) :: reading
      type(model_t), intent(in) :: model
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: entry
      logical :: is_required
      integer :: k
      is_required = any(rule%verdict == [requires, no_effect_without])
      is_broken = is_met(reading, 0, .false., model, settings, entry)
      if (.not. is_broken) return
      is_broken = is_required .neqv. any([(is_met(reading, k, rule%verdict == requires, model, settings, entry), &
                                           k=1, max(1, maxval(reading%atoms%alternative)))])
      if (is_broken .and. is_required) is_broken = all_known(reading, settings, entry)
   end function is_broken

   !> Whether all words of an alternative of a rule are met.
   pure logical function is_met(reading, alternative, by_all, model, settings, entry)
      type(reading_t), intent(in) :: reading
      integer, intent(in) :: alternative
      logical, intent(in) :: by_all              !! whether all groups must meet it, if it is not about the group of the message
      type(model_t), intent(in) :: model
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: entry
      integer :: i
      is_met = .true.
      do i = 1, size(reading%atoms)
         associate (atom => reading%atoms(i))
            if (atom%alternative /= alternative .or. .not. is_met) cycle
            if (atom%group == 0 .or. atom%group == reading%atoms(1)%group) then
               is_met = holds(atom, model, settings, entry)
            else
               is_met = merge(reading%everywhere(i), reading%met_by(i) > 0, by_all)
            end if
         end associate
      end do
   end function is_met

   !> Whether no error was found in the keys that a rule requires.
   pure logical function all_known(reading, settings, entry) result(known)
      type(reading_t), intent(in) :: reading
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: entry
      integer :: i, k
      known = .true.
      do i = reading%first + 1, size(reading%atoms)
         associate (atom => reading%atoms(i))
            if (atom%key == 0) cycle
            do k = 1, settings%count
               if (settings%entries(k)%group /= atom%group .or. k /= entry .and. atom%group == reading%atoms(1)%group) cycle
               known = known .and. settings%entries(k)%settings(atom%key)%good
            end do
         end associate
      end do
   end function all_known

   !> Whether a group counts in rules with others: materials with a body do, and bodies that are no holes.
   pure logical function counts(model, settings, entry)
      type(model_t), intent(in) :: model
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: entry               !! position of the group
      integer :: i
      counts = .true.
      if (settings%entries(entry)%name == 'body') counts = .not. settings%flag(entry, 'hole')
      if (settings%entries(entry)%name == 'material') &
         counts = any(model%materials%number == count([(settings%entries(i)%name == 'material', i=1, entry)]))
   end function counts

   !> Message of a broken rule, as a sentence without its full stop.
   pure function message_of(rule, reading, settings, entry) result(message)
      type(rule_t), intent(in) :: rule
      type(reading_t), intent(in) :: reading
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: entry               !! position of the group, here and below
      character(:), allocatable :: message, other
      integer :: i
      message = shown_atom(reading%atoms(1), settings, entry)
      if (reading%atoms(1)%key > 0) then
         if (.not. settings%entries(entry)%settings(reading%atoms(1)%key)%given) message = message//' (default)'
      end if
      do i = 2, reading%first
         message = message//trim(merge(' with', ' and ', i == 2))//' '//shown_other(reading, i, settings, entry)
      end do
      other = ''
      if (any(rule%verdict == [requires, no_effect_without])) other = required_text(rule)
      if (other == '') then                      ! as the model meets it
         do i = reading%first + 1, size(reading%atoms)
            if (other /= '') other = other//' and '
            other = other//shown_other(reading, i, settings, entry)
         end do
      end if
      if (other /= '') message = message//' '//trim(words(rule%verdict))//' '//other
      if (rule%reason /= '') message = message//': '//trim(rule%reason)
   end function message_of

   !> A word behind the first one: without its group where this is the same.
   pure function shown_other(reading, i, settings, entry) result(text)
      type(reading_t), intent(in) :: reading
      integer, intent(in) :: i
      type(settings_t), intent(in) :: settings
      integer, intent(in) :: entry               !! group of the first word
      character(:), allocatable :: text
      associate (atom => reading%atoms(i))
         text = shown_atom(atom, settings, merge(entry, reading%met_by(i), atom%group == reading%atoms(1)%group))
         if (atom%group == reading%atoms(1)%group .and. atom%key > 0) text = text(len('& ') + len(settings%title(entry)) + 1:)
      end associate
   end function shown_other

   !> The other condition of a rule as it stands, without the name of the group that the first has, and with `or` between values.
   pure function required_text(rule) result(text)
      type(rule_t), intent(in) :: rule
      character(:), allocatable :: text, group
      integer :: at
      group = rule%subject(:index(rule%subject, ' '))
      text = trim(rule%other)
      do
         at = index(text//' ', group)
         if (at == 0 .or. index(rule%subject, '&') /= 1 .or. at + len(group) > len(text)) exit
         text = text(:at - 1)//text(at + len(group):)
      end do
      text = with_or(text)
   end function required_text

   !> A condition with `or` between values.
   pure function with_or(condition) result(text)
      character(*), intent(in) :: condition
      character(:), allocatable :: text
      integer :: at
      text = expanded(condition, '''', ' | ')
      do
         at = index(text, ' | ')
         if (at == 0) return
         text = text(:at)//'or'//text(at + 2:)
      end do
   end function with_or

   !> Name of the key of a word, '' where it has none.
   pure function key_of(atom) result(name)
      type(atom_t), intent(in) :: atom
      character(:), allocatable :: name
      name = ''
      if (atom%key > 0) name = trim(keys(first_key(atom%group) + atom%key - 1)%name)
   end function key_of

   !> Whether a model may take an advice: with it no further rule refuses the model, nor the advice itself. Advice in words is
   !> always allowed.
   pure logical function is_allowed(rule, entry, settings, broken)
      type(rule_t), intent(in) :: rule
      integer, intent(in) :: entry               !! position of the group of the message
      type(settings_t), intent(in) :: settings
      logical, intent(in) :: broken(:)           !! rules that are broken without it
      type(atom_t), allocatable :: advice(:)
      type(settings_t) :: changed
      type(model_t) :: other
      type(breach_t), allocatable :: breaches(:)
      logical :: anew(size(rules))
      integer :: i, k
      is_allowed = rule%of_use == 0
      if (is_allowed) return
      i = rule%behind + rule%of_subject + rule%of_other
      advice = atoms(i + 1:i + rule%of_use)
      changed = settings
      do k = 1, changed%count
         do i = 1, size(advice)
            if (changed%entries(k)%group /= advice(i)%group .or. advice(i)%key == 0) cycle
            if (settings%entries(entry)%group == advice(i)%group .and. k /= entry) cycle
            call give(changed%entries(k)%settings(advice(i)%key), advice(i))
         end do
      end do
      call fill_model(changed, other)
      call find_breaches(other, changed, breaches)
      anew = .false.
      anew(breaches%rule) = rules(breaches%rule)%verdict == not_with .or. rules(breaches%rule)%verdict == requires
      is_allowed = .not. any(anew .and. .not. broken)
      do k = 1, size(breaches)
         associate (subject => atoms(rules(breaches(k)%rule)%behind + 1))
            if (anew(breaches(k)%rule)) is_allowed = is_allowed .and. &
               .not. any(advice%group == subject%group .and. advice%key == subject%key)
         end associate
      end do
   end function is_allowed

   !> Give a setting the value of a word.
   pure subroutine give(setting, atom)
      type(setting_t), intent(inout) :: setting
      type(atom_t), intent(in) :: atom
      setting%good = .true.
      setting%given = .true.
      if (setting%count < 1) return
      setting%count = 1
      if (atom%last >= atom%first) then
         setting%values(1)%text = trim(values(atom%first))
      else
         setting%numbers(1) = atom%number
      end if
   end subroutine give
end module hampm_rule_check
