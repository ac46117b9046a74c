import unittest

from made_up import PLAN, edges_in_time
from witness import compare, plan

TEXT = """duration_us: 2000.5
steps {
  role: GRADIENT_X
  wait: "LED chain: \\"}\\" is no brace"
}
steps {
}
edges {
  planned_us: 12.5
  tolerance_us: 50
  line: "BLANK"
  value: 1
}
budget {
  leds_share: 0.5
}
"""


class CompareTest(unittest.TestCase):
    def test_a_perfect_burst_deviates_nowhere(self):
        result = compare.compare(PLAN, edges_in_time())
        self.assertIsNone(result.order_fault)
        self.assertEqual(result.zero_ns, 5_000_000)
        self.assertEqual({d.us for d in result.deviations}, {0})

    def test_one_late_edge_shows_whole_and_moves_no_other(self):
        edges = edges_in_time()
        edges[3] = edges[3]._replace(t_ns=edges[3].t_ns + 200_000)
        beyond = [d for d in compare.compare(PLAN, edges).deviations if d.is_beyond_tolerance()]
        self.assertEqual([(d.planned.line, d.us) for d in beyond], [("BLANK", 200)])

    def test_an_early_edge_is_as_wrong_as_a_late_one(self):
        edges = edges_in_time()
        edges[3] = edges[3]._replace(t_ns=edges[3].t_ns - 60_000)
        self.assertTrue(any(d.is_beyond_tolerance()
                            for d in compare.compare(PLAN, edges).deviations))

    def test_a_missing_edge_is_a_fault_of_order(self):
        edges = edges_in_time()
        self.assertIn("BLANK to 0 of step 0 was planned, BLANK to 1 happened",
                      compare.compare(PLAN, edges[:3] + edges[4:]).order_fault)
        self.assertIn("never happened", compare.compare(PLAN, edges[:-1]).order_fault)

    def test_an_edge_too_many_is_a_fault_of_order(self):
        edges = edges_in_time()
        more = edges + [edges[-1]._replace(t_ns=edges[-1].t_ns + 1, value=1)]
        self.assertIn("after the plan's last edge", compare.compare(PLAN, more).order_fault)

    def test_no_edges_at_all_are_a_fault(self):
        self.assertIsNotNone(compare.compare(PLAN, []).order_fault)

    def test_the_largest_is_taken_by_size(self):
        edge = PLAN.edges[4]
        found = compare.largest([compare.Deviation(edge, 3), compare.Deviation(edge, -4)], "BLANK")
        self.assertEqual(found.us, -4)
        self.assertIsNone(compare.largest([], "BLANK"))


class PlanTest(unittest.TestCase):
    def test_text_is_read_and_zeros_that_are_not_written_are_zeros(self):
        read = plan.from_text(TEXT)
        self.assertEqual(read.edges, [plan.PlannedEdge(12.5, 50, "BLANK", 1, 0)])
        self.assertEqual(read.roles, ["GRADIENT_X", "ROLE_UNSPECIFIED"])

    def test_a_plan_that_the_rig_refuses_is_refused(self):
        with self.assertRaisesRegex(ValueError, "too hot"):
            plan.from_text('refusal: "too hot"\n')


if __name__ == "__main__":
    unittest.main()
