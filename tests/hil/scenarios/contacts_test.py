#!/usr/bin/env python3
"""Contacts without a number of sub-steps, against runs at 1/64 of their parts: contacts_test.py BIN_FOLDER SOURCE_FOLDER"""
import importlib.machinery
import importlib.util

from processes import SOURCE, UNLATCH, ProcessTest, main

loader = importlib.machinery.SourceFileLoader("contacts", str(SOURCE / "bench/contacts"))
contacts = importlib.util.module_from_spec(importlib.util.spec_from_loader("contacts", loader))
loader.exec_module(contacts)

PLACE, TIME = 1e-5, 2e-6  # m, s


class ContactsTest(ProcessTest):
    def test_every_case_is_right_without_a_number_of_sub_steps(self):
        self.assertGreater(len(contacts.CASES), 3)
        for scenario in contacts.CASES:
            run = contacts.fly(UNLATCH, scenario)
            place, time, value = contacts.compare(run, contacts.fly_reference(UNLATCH, scenario))
            self.assertLess(place, PLACE, scenario)
            self.assertLess(time, TIME, scenario)
            self.assertLess(value, 1e-4, scenario)
            self.assertIn(run["status"], ("ok",), scenario)

    def test_one_sub_step_is_wrong_and_unresolved(self):
        rails = SOURCE / "bench/contact_cases/rails.yaml"
        run = contacts.fly(UNLATCH, rails, contact_substeps=1)
        place, _, value = contacts.compare(run, contacts.fly(UNLATCH, rails))
        self.assertGreater(place, 1e-4)
        self.assertGreater(value, 0.1)
        self.assertEqual(run["status"], "unresolved")


if __name__ == "__main__":
    main()
