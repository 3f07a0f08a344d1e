!> The table of rules as text, which `--rules` prints: docs/reference/key_rules.md is this text, and `--json` the same for programs.
module hampm_rule_reference
   use hampm_choice_sets, only: expanded
   use hampm_json, only: array, item, member, object
   use hampm_keys, only: groups
   use hampm_rule_table, only: rules
   use hampm_rules, only: rule_t, not_with, requires, no_effect_with, no_effect_without, warned_with, noted_with, &
                          mechanics, not_built, by_meaning
   use hampm_rule_check, only: required_text, with_or, words
   use hampm_text, only: line, paragraph, to_text
   implicit none
   private
   public :: rules_text, rules_json

   character(*), parameter :: verdicts(*) = [character(24) :: 'not allowed with', 'requires', 'no effect with', &
                                             'no effect without', 'warned of with', 'noted with']
   character(*), parameter :: bases(*) = [character(24) :: 'mechanics', 'not built', 'meaning of the keys']

contains

   !> All rules in sentences, group by group.
   pure function rules_text() result(text)
      character(:), allocatable :: text
      integer :: g
      text = line('# How keys depend on each other')//line('') &
             //paragraph('The output of `hampm --rules`, from the table by which models are validated '// &
                         '(`src/input/schema`); `hampm --rules --json` has it for programs. [keys.md](keys.md) has what '// &
                         'each key allows by itself, [places.md](places.md) where things have to be and which numbers go '// &
                         'together. All errors are reported at once, and `hampm --check` looks for them without a run.', 0) &
             //line('') &
             //paragraph('A model that breaks a rule with "requires" or "is not allowed with" is refused; one with "has no '// &
                         'effect" or "warning:" runs, and says so. A key has no effect only where it is given, and says '// &
                         'something else than its default. Where a rule is about another group of which there may be several, '// &
                         '"requires" means all of these, and every other word any of them. Only materials of which there is a '// &
                         'body and bodies that are no holes count there.', 0) &
             //line('') &
             //paragraph('Of '//to_text(count(.not. is_void(rules)))//' rules '//to_text(number(not_with) + number(requires))// &
                         ' refuse a model, '//to_text(number(no_effect_with) + number(no_effect_without))// &
                         ' are about keys without effect, and '//to_text(number(warned_with) + number(noted_with))// &
                         ' warn. The reason of '//to_text(with_reason(mechanics))//' is one of mechanics, '// &
                         to_text(with_reason(by_meaning))//' follow from what keys mean, and '// &
                         to_text(with_reason(not_built))//' say "(not built)": there is none but that the program '// &
                         'cannot do it yet.', 0)
      do g = 1, size(groups)
         text = text//section('## &'//trim(groups(g)%name), trim(groups(g)%name))
      end do
   end function rules_text

   !> How many rules have a verdict.
   pure integer function number(verdict)
      integer, intent(in) :: verdict
      number = count(rules%verdict == verdict .and. .not. is_void(rules))
   end function number

   !> How many rules have a reason of a kind.
   pure integer function with_reason(basis)
      integer, intent(in) :: basis
      with_reason = count(rules%basis == basis .and. .not. is_void(rules))
   end function with_reason

   !> Whether a rule is about choices of which the program has none.
   elemental logical function is_void(rule)
      type(rule_t), intent(in) :: rule
      is_void = index(with_or(trim(rule%subject)), ' = ''''') > 0
   end function is_void

   !> The rules whose message is about a group; '' where there are no such rules.
   pure function section(title, group) result(text)
      character(*), intent(in) :: title, group
      character(:), allocatable :: text
      integer :: k
      text = ''
      do k = 1, size(rules)
         if (rules(k)%subject(2:index(rules(k)%subject, ' ') - 1) /= group .or. is_void(rules(k))) cycle
         if (text == '') text = line('')//line(title)//line('')
         text = text//paragraph('- '//sentence(rules(k)), 2)
      end do
   end function section

   !> A rule as a sentence.
   pure function sentence(rule) result(text)
      type(rule_t), intent(in) :: rule
      character(:), allocatable :: text
      text = as_code(with_or(trim(rule%subject)))
      if (rule%other /= '') text = text//' '//trim(words(rule%verdict))//' '//as_code(required_text(rule))
      if (rule%verdict == warned_with) text = 'warning: '//text
      if (rule%verdict == noted_with) text = 'note: '//text
      if (rule%basis == not_built) text = text//' (not built)'
      if (rule%reason /= '') text = text//': '//trim(rule%reason)
      if (rule%use(1:1) == '&') then
         text = text//'; use '//as_code(trim(rule%use))
      else if (rule%use /= '') then
         text = text//'; use '//trim(rule%use)
      end if
      text = text//'.'
   end function sentence

   !> A condition whose words about keys and values are marked as code.
   pure function as_code(condition) result(text)
      character(*), intent(in) :: condition
      character(:), allocatable :: text
      integer :: from, behind
      text = ''
      from = 1
      do while (from <= len(condition))
         behind = next_break(condition(from:)) + from - 1
         if (scan(condition(from:behind - 1), '&=><''') > 0 .or. index(condition(from:behind - 1), ' ') == 0) then
            text = text//'`'//condition(from:behind - 1)//'`'
         else
            text = text//condition(from:behind - 1)
         end if
         if (behind > len(condition)) exit
         from = behind + index(condition(behind + 1:), ' ') + 1
         text = text//condition(behind:from - 1)
      end do
   end function as_code

   !> Position of the next `and` or `or` with the blank before it; past the end for none.
   pure integer function next_break(text)
      character(*), intent(in) :: text
      integer :: i, at(2)
      at = [index(text, ' and '), index(text, ' or ')]
      next_break = minval([(merge(at(i), len_trim(text) + 1, at(i) > 0), i=1, 2)])
   end function next_break

   !> All rules as JSON.
   pure function rules_json() result(text)
      character(:), allocatable :: text
      integer :: k
      text = ''
      do k = 1, size(rules)
         associate (rule => rules(k))
            if (.not. is_void(rule)) text = text//item(new_line('a')//' '//object( &
               member('subject', trim(expanded(rule%subject, '''', ' | ')))// &
               member('verdict', trim(verdicts(rule%verdict)))//member('other', trim(expanded(rule%other, '''', ' | ')))// &
               member('basis', trim(bases(rule%basis)))//member('reason', trim(rule%reason))//member('use', trim(rule%use))))
         end associate
      end do
      text = line(array(text))
   end function rules_json
end module hampm_rule_reference
